// Contacts on the simulated fingertip, to train networks where nothing was recorded.
#pragma once

#include <cstdint>
#include <vector>

#include <Eigen/Core>

#include "slave/capture/tactile_frame.h"

namespace palpate {

struct SimulatedPresses {
  int presses = 300;  // total number, >= 1; the program has another default
  // Number of presses after which the fingertip restarts with another baseline; >= 1.
  int per_start = 5;
  double largest_force = 5;  // along the normal [N], > 0
  int rest_samples = 50;     // without contact at the start, >= 1; 20 more follow
  std::uint64_t seed = 1;
};

// Samples from one switching-on of the fingertip, at kPressRate.
struct SimulatedStart {
  std::vector<FingerReading> readings;  // raw counts
  std::vector<Eigen::Vector3d> force;   // of the fingertip on the object, frame F [N]
};
inline constexpr double kPressRate = 100;  // [Hz]

// Number of times that the fingertip is switched on. Throws std::invalid_argument: an option.
int CountStarts(const SimulatedPresses& options);

// Returns the samples after switching on for the `start`-th time, counted from 0, independent of
// other starts. Every contact has a position on the pad, the tip or the sides, a peak force, an
// object between foam and hard rubber with the shape of a sphere or a flat probe of its own width,
// and tangential forces up to half of the normal one that vary; it is ramped up, held and released,
// and the next one follows after a pause.
SimulatedStart SimulateStart(const SimulatedPresses& options, int start);

}  // namespace palpate
