// Whether the numbers of a received state can be used at all.
#pragma once

#include "shared/state/slave_state.h"

namespace palpate {

// Finite and of at most this size in each direction.
bool IsWithin(const Eigen::Vector3d& v, double limit);
// Positions, forces and number of fingertips of a state.
bool IsSane(const SlaveState& state);

inline constexpr double kFarthest = 1e4;  // larger positions are invalid [m]

}  // namespace palpate
