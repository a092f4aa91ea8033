// Recordings whose force is a known function of the signals.
#pragma once

#include <cmath>
#include <random>
#include <string>
#include <vector>

#include "slave/tactile/recordings/labelled_recording.h"

namespace palpate::testing {

// Presses of two seconds with `rest` samples before and after each. The force follows three
// electrodes, each with gains of its own; the others are noise of one count.
inline LabelledRecording SyntheticRecording(int presses, std::uint32_t seed, int rest = 100) {
  std::mt19937 random(seed);
  std::normal_distribution<float> noise(0, 1);
  std::uniform_real_distribution<float> peak(0.2F, 1);
  LabelledRecording recording;
  recording.name = "synthetic " + std::to_string(seed);
  for (int press = 0; press < presses; ++press) {
    const Eigen::Vector3f size(peak(random) - 0.6F, peak(random) - 0.6F, -peak(random));
    for (int i = 0; i < 2 * rest + 200; ++i) {
      const bool touching = i >= rest && i < rest + 200;
      const float share =
          touching ? std::sin(static_cast<float>(M_PI) * static_cast<float>(i - rest) / 200) : 0.0F;
      const Eigen::Vector3f force = share * size;
      TactileSignals change{};
      for (double& signal : change) signal = static_cast<double>(noise(random));
      change[0] += static_cast<double>(100 * force.x());
      change[1] += static_cast<double>(80 * force.y());
      change[2] += static_cast<double>(120 * force.z());
      recording.t.push_back(0.01 * static_cast<double>(recording.t.size()));
      recording.change.push_back(change);
      recording.force.push_back(force);
    }
  }
  recording.end = recording.t.size();
  return recording;
}

}  // namespace palpate::testing
