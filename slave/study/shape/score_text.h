// Numbers of an evaluation, for people and for programs.
#pragma once

#include <string>

#include <nlohmann/json_fwd.hpp>

#include "slave/study/shape/shape_score.h"

namespace palpate::study {

// 0.9731: `97.3 %`; NaN: `unknown`.
std::string Percent(double share);
// 0.0123: `12.3 mm`.
std::string Millimetres(double length);
// Unknown values are null.
nlohmann::ordered_json DistanceJson(const DistanceSummary& distances);
nlohmann::ordered_json ScoreJson(const ShapeScore& score, double leaf);

}  // namespace palpate::study
