// Force networks as ONNX files, run by OpenCV.
#pragma once

#include <filesystem>
#include <memory>

#include "slave/tactile/network/force_network.h"

namespace palpate {

// A model with one input, [1, n] or [1, window, n] with n = 21 or 19 counts minus rest and at most
// 1000 samples (window 50 where the model leaves it open), whose first output holds one row of 3 or
// more numbers, the force of the fingertip on the object, frame F [N], first. Its estimates
// allocate: OpenCV does. Throws std::runtime_error naming the file and what is wrong: no ONNX, cut
// off, other shapes, an operator that OpenCV does not run (its name).
std::unique_ptr<ForceNetwork> LoadOnnxNetwork(const std::filesystem::path& file);

}  // namespace palpate
