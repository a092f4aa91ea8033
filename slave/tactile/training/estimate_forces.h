// What a network says of recordings whose force is known.
#pragma once

#include <span>
#include <vector>

#include <Eigen/Core>

#include "slave/tactile/network/force_network.h"
#include "slave/tactile/recordings/labelled_recording.h"

namespace palpate {

// The force at the windows' ends [N]: the exact windowed evaluation, sample by sample through every
// recording from its start. A window before the network's own is full: NaN.
std::vector<Eigen::Vector3f> EstimateForces(const ForceNetwork& network,
                                            std::span<const LabelledRecording> recordings,
                                            std::span<const Window> windows);
// What was measured there [N].
std::vector<Eigen::Vector3f> MeasuredForces(std::span<const LabelledRecording> recordings,
                                            std::span<const Window> windows);

}  // namespace palpate
