// The checks of one fingertip, and their input per sample.
#pragma once

#include <optional>
#include <string_view>

#include "slave/checks/check.h"
#include "slave/checks/consistency.h"
#include "slave/tactile/fingertip.h"

namespace palpate {

// FingertipSample is the input for one sample of a fingertip: its signals, their place on the
// object by the pose, and the encoders.
struct FingertipSample {
  const Fingertip& tip;
  Consistency* consistency;          // collects the residuals of this sample
  std::optional<double> depth = {};  // below the surface at rest [m]; nullopt: unknown
  std::string_view misplaced = {};   // why the pose does not fit the object; empty: it does
  bool is_beyond_model = false;      // the force exceeds the range of the model
  // Normal force of the tool's fingertip in a deep contact, over that of the local model [-].
  std::optional<double> force_ratio = {};
  double force_ratio_sigma = 0;              // contribution of the force's sigma
  std::optional<double> encoder_error = {};  // distance from the encoder pose [m]; nullopt: unknown
};

// Called once per sample, with a known force or without.
Checks<FingertipSample> MakeFingertipChecks();

}  // namespace palpate
