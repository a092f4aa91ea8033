// Tables of measured and estimated forces: of any source, or of a scene's run.
#pragma once

#include <filesystem>
#include <map>
#include <string>
#include <vector>

#include "slave/verify/compare_forces.h"

namespace palpate {

// Names of columns, with commas between those of a force; `-` in place of a name: this axis is
// unknown. A single name is z. Units are those of FindUnit, and g for gram-force.
struct ForceColumns {
  std::string measured = "measured_fx,measured_fy,measured_fz";
  std::string estimated = "estimated_fx,estimated_fy,estimated_fz";
  std::string time = "t", sigma = "sigma", validity = "validity";
  std::string measured_unit = "N", estimated_unit = "N", time_unit = "s";
};

// Rows of each finger; an empty name is the only tool.
using ForceTables = std::map<std::string, std::vector<ForceRow>>;

// Columns beside those that `columns` names: finger, hold, known_x to
// known_z, tip_x to tip_z, known_depth, depth; all may be absent. A unit in brackets behind a title
// counts in place of that of `columns`. Throws InputError with file and line: no axis with both
// forces, a time that falls, no number; std::invalid_argument: a unit.
ForceTables ReadForces(const std::filesystem::path& file, const ForceColumns& columns);

// Writes what ReadForces reads with the usual names. Throws std::system_error.
void WriteForces(const ForceTables& tables, const std::filesystem::path& file);

}  // namespace palpate
