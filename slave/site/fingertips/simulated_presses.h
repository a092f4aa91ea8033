// Contacts on the simulated fingertip, to learn from where nothing was recorded.
#pragma once

#include <cstdint>
#include <vector>

#include "slave/tactile/recordings/labelled_recording.h"

namespace palpate {

struct SimulatedPresses {
  int presses = 300;         // in all, >= 1
  int per_start = 5;         // then the fingertip starts again, with another baseline; >= 1
  double largest_force = 5;  // along the normal [N], > 0
  int rest_samples = 50;     // whose mean is subtracted, >= 1
  std::uint64_t seed = 1;
};

// One recording per start at 100 Hz. Every contact has a position on the pad, the tip or the sides,
// a peak force, an object between foam and hard rubber with the shape of a sphere or a flat probe
// of its own width, and tangential forces up to half of the normal one that vary; it is ramped up,
// held and released, and the next one follows after a pause. Throws std::invalid_argument: an
// option.
std::vector<LabelledRecording> SimulatePresses(const SimulatedPresses& options);

}  // namespace palpate
