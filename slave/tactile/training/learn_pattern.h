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

}  // namespace palpate
