// Tactile samples with a known force, for training and testing of networks, and their split.
#pragma once

#include <cstddef>
#include <cstdint>
#include <filesystem>
#include <span>
#include <string>
#include <vector>

#include <Eigen/Core>

#include "slave/tactile/signals/rest_values.h"

namespace palpate {

inline constexpr double kNetworkRate = 100;  // of the samples [Hz]

// One fingertip without a gap, at the rate of the networks. All vectors are of the same length.
struct LabelledRecording {
  std::string name;                         // for people: the file's name, or which simulated start
  std::filesystem::path file;               // empty: simulated
  std::vector<double> t = {};               // [s], as in the file
  std::vector<TactileSignals> change = {};  // counts minus rest
  std::vector<Eigen::Vector3f> force = {};  // of the fingertip on the object, frame F [N]
  // The selected instants, [begin, end). Windows may begin before `begin`.
  std::size_t begin = 0, end = 0;
  std::string missing_column = {};  // pac0 or pdc where the file lacks it; those read 0
};

// Instants [begin, end) of a recording that belong together, usually one contact. Windows that end
// there contain no sample before `look_back`.
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

// The contacts of the selected instants: stretches of contact, each with half of the quiet time
// around it. Contact: |force| above 5 % of the largest of all; pauses below half a second are part
// of it. A recording without contact is one stretch of rest and is not used.
std::vector<Stretch> FindPresses(std::span<const LabelledRecording> recordings);

// Contacts for training, validation and test. No sample is in more than one part.
struct Split {
  std::vector<Stretch> train, validation, test;
  std::string how;  // description for the summary
};

// The split of the paper (IV.A): 80 % for training and 20 % for the test, 20 % of the first for
// validation, by whole recordings if there are at least five, else by whole contacts; `seed`
// selects them. With fewer than four contacts there is no separate validation, with one no separate
// test: these parts are then parts of a contact, as `how` states. `test_is_apart`: the test
// recordings are separate and no contacts are reserved for them. Throws std::invalid_argument: no
// contact.
Split SplitContacts(std::span<const LabelledRecording> recordings, bool test_is_apart,
                    std::uint64_t seed);

}  // namespace palpate
