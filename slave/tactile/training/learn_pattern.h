// Learns how the signals of a fingertip go together (SignalPattern).
#pragma once

#include <span>

#include "slave/tactile/recordings/labelled_recording.h"
#include "slave/tactile/signal_pattern.h"

namespace palpate {

// From the samples of `windows` whose signals stand well out of their noise. Unknown where these
// are fewer than a hundred times the signals.
SignalPattern LearnPattern(std::span<const LabelledRecording> recordings,
                           std::span<const Window> windows);

// Measures how wrong the network's forces are of contacts of each kind: `estimated` at the ends of
// `windows`, which it did not learn from, beside what was measured there [N]. A kind that has too
// few of them stays as it is.
void LearnErrors(std::span<const LabelledRecording> recordings, std::span<const Window> windows,
                 std::span<const Eigen::Vector3f> estimated,
                 std::span<const Eigen::Vector3f> measured, SignalPattern* pattern);

}  // namespace palpate
