// Numbers for CSV files, the same in every locale.
#pragma once

#include <string>

namespace palpate {

// Appends `value` with `digits` significant ones (1 to 17; 17 round-trips); nothing if it is not
// finite: an empty cell is a number that is not known.
void AppendNumber(std::string* text, double value, int digits);

}  // namespace palpate
