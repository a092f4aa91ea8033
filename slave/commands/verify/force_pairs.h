// Pairs of measured and estimated forces of any source, from a table.
#pragma once

#include <filesystem>
#include <string>
#include <vector>

#include "slave/commands/verify/known_loads.h"

namespace palpate {

// Names of columns, with commas between those of a force; `-` in place of a name: this axis is
// unknown. One name alone is z. Units are those of FindUnit, and g for gram-force.
struct ForceColumns {
  std::string measured = "measured_fx,measured_fy,measured_fz";
  std::string estimated = "estimated_fx,estimated_fy,estimated_fz";
  std::string time = "t", sigma = "sigma", validity = "validity";
  std::string measured_unit = "N", estimated_unit = "N", time_unit = "s";
};

// Rows in order of time, or of the file if a row has no time. A unit in brackets behind a title
// counts in place of that of `columns`. Axes that both forces lack are unknown, and rows with an
// empty cell. Throws InputError with file and line; std::invalid_argument: a unit.
std::vector<MatchedState> ReadForcePairs(const std::filesystem::path& file,
                                         const ForceColumns& columns);

}  // namespace palpate
