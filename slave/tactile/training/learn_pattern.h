// Learns the correlation of a fingertip's signals (SignalPattern).
#pragma once

#include <span>

#include "slave/tactile/recordings/labelled_recording.h"
#include "slave/tactile/signals/signal_pattern.h"

namespace palpate {

// Uses the samples of `windows` whose signals are well above their noise. Unknown if there are
// fewer than a hundred times the number of signals.
SignalPattern LearnPattern(std::span<const LabelledRecording> recordings,
                           std::span<const Window> windows);

// Measures the error of the network's forces for each kind of contact: `estimated` at the ends of
// `windows`, which were not used for training, against the measured values [N]. A kind with too few
// windows is unchanged.
void LearnErrors(std::span<const LabelledRecording> recordings, std::span<const Window> windows,
                 std::span<const Eigen::Vector3f> estimated,
                 std::span<const Eigen::Vector3f> measured, SignalPattern* pattern);

}  // namespace palpate
