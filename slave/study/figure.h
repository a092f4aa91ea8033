// The trade as a picture: error over update time and over precompute, all logarithmic.
#pragma once

#include <string>

#include "slave/study/study.h"

namespace palpate::study {

// An SVG document: one colour and marker per family, bars where the error is uncertain, the front
// as a line, a box for what the scene asks for, a ring around the recommended row. Rows without a
// known error are not drawn. Dark on light or light on dark, as the reader's system prefers.
std::string DrawFigure(const StudyResult& study);

}  // namespace palpate::study
