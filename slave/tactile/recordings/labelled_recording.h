// Tactile samples whose force is known: what networks learn from and are measured by.
#pragma once

#include <cstddef>
#include <filesystem>
#include <span>
#include <string>
#include <vector>

#include <Eigen/Core>

#include "slave/tactile/rest_values.h"

namespace palpate {

inline constexpr double kNetworkRate = 100;  // of the samples [Hz]

// One fingertip without a gap, at the rate of the networks. All vectors are of the same length.
struct LabelledRecording {
  std::string name;                         // for people: the file's name, or which simulated start
  std::filesystem::path file;               // empty: simulated
  std::vector<double> t = {};               // [s], as in the file
  std::vector<TactileSignals> change = {};  // counts minus rest
  std::vector<Eigen::Vector3f> force = {};  // of the fingertip on the object, frame F [N]
  // The instants that are wanted, [begin, end). Windows may look back before `begin`.
  std::size_t begin = 0, end = 0;
  std::string missing_column = {};  // pac0 or pdc where the file lacks it; those read 0
};

// Instants [begin, end) of a recording that belong together, a whole press as a rule. Windows that
// end there contain no sample before `look_back`.
struct Stretch {
  std::size_t recording = 0;
  std::size_t begin = 0, end = 0;
  std::size_t look_back = 0;
};

// A window by its last sample.
struct Window {
  std::size_t recording = 0, last = 0;
};
// Every window of `steps` samples that ends in one of the stretches and stays within its look-back.
std::vector<Window> WindowsOf(std::span<const Stretch> stretches, int steps);

// The presses of the wanted instants: stretches of contact, each with half of the quiet time around
// it. Contact: |force| above 5 % of the largest of all; pauses below half a second are part of it.
// A recording without contact is one stretch of rest and is left out.
std::vector<Stretch> FindPresses(std::span<const LabelledRecording> recordings);

}  // namespace palpate
