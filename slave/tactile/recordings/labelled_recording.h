// Tactile samples whose force is known: what networks learn from and are measured by, and which of
// them for which.
#pragma once

#include <cstddef>
#include <cstdint>
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

// Which contacts are learnt from, which decide when to stop, and which are only measured. No sample
// is in more than one part.
struct Split {
  std::vector<Stretch> train, validation, test;
  std::string how;  // in words, for the summary
};

// The paper's split (IV.A): 80 % to train and 20 % to test, 20 % of the first to validate, by whole
// recordings where there are at least five, else by whole presses; what goes where is drawn by
// `seed`. Fewer than four presses leave none to validate, and one alone none to test: those parts
// are then parts of a press, as `how` says. `test_is_apart`: the test recordings are others,
// nothing is set aside for them. Throws std::invalid_argument: there is no contact.
Split SplitContacts(std::span<const LabelledRecording> recordings, bool test_is_apart,
                    std::uint64_t seed);

}  // namespace palpate
