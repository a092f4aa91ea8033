// Which contacts are learnt from, which decide when to stop, and which are only measured.
#pragma once

#include <cstdint>
#include <span>
#include <string>
#include <vector>

#include "slave/tactile/recordings/labelled_recording.h"

namespace palpate {

// No sample is in more than one part.
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
