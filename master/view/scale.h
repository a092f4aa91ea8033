// Scales of a picture: round ends that do not flicker, colours between them, numbers in words.
#pragma once

#include <string>

namespace palpate {

// The least 1, 2, 4, 6 or 8 times a power of ten that is not below `value` > 0; `floor` > 0 for
// less.
double RoundedUp(double value, double floor);

// Colour of `share` of a scale, 0 (pale) to 1 (dark), under `light`, 0 (dark) to 1, as `#rrggbb`.
std::string ColourOf(double share, double light = 1);

// `value` with so many significant digits as a person reads: 0.412, 12.5, 1e+06.
std::string Readable(double value);

}  // namespace palpate
