// Reported states and known loads, which make the rows of a table of forces.
#pragma once

#include <filesystem>
#include <string>
#include <vector>

#include "slave/verify/force_table.h"

namespace palpate {

// A known load on the tool during an interval. Frame S; NaN: unknown.
struct KnownLoad {
  double from = 0, until = 0;               // on the clock of the states [s]
  std::string finger;                       // empty: the first one by name
  Eigen::Vector3d force = kUnknownVector3;  // of the object on the tool [N]
  double sigma = kUnknown;                  // standard deviation of an axis of it [N]
  Eigen::Vector3d p_S_tip = kUnknownVector3;
  double depth = kUnknown;
};

struct LoadTable {
  std::vector<KnownLoad> loads;
  bool is_record = false;  // rows are instants of a record, without `until`
};

// states.csv of `process`: the measured force of a row is the simulator's true one. Throws
// InputError.
ForceTables ReadStates(const std::filesystem::path& file);

// Columns t, until, finger, fx, fy, fz, sigma, x, y, z, depth. All but t are optional. An empty
// cell or an absent column is unknown. A table without `until` is a record, which is interpolated
// linearly between rows that are at most 1 s apart. Throws InputError.
LoadTable ReadLoads(const std::filesystem::path& file);

// A load as a user describes it: `weight 100 g +y`, `spring 200 N/m 5 mm +y`, `force 0 1.2 0`,
// `press 3 mm`, `none`; followed by `at X Y Z` [m] if the tip position is known. Directions are
// those in which the object pushes the tool. Throws std::invalid_argument with what is accepted.
KnownLoad ParseLoad(const std::string& line);

// Replaces the measured force of `state` by `load`, whose number is `hold`. A reference without a
// sigma gets 1 %: weights, springs and gauges are rarely better, and so is the timing of a changing
// force.
ForceRow WithLoad(ForceRow state, const KnownLoad& load, int hold);

// The states during loads, with these. Throws std::invalid_argument: there are none.
ForceTables WithLoads(const ForceTables& states, const LoadTable& table);

// The states with the force of a sensor. Throws std::invalid_argument: there are none.
ForceTables WithSensor(const ForceTables& states);

}  // namespace palpate
