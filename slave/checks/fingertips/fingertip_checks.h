// The checks of one fingertip, and what they get of each sample.
#pragma once

#include <optional>
#include <string_view>

#include "slave/checks/check.h"
#include "slave/tactile/fingertip.h"

namespace palpate {

// Signals, and their place on the object by the pose.
struct FingertipSample {
  const Fingertip& tip;
  std::optional<double> depth = {};  // below the surface at rest [m]; nullopt: unknown
  std::string_view misplaced = {};   // why the pose does not fit the object; empty: it does
  bool is_beyond_model = false;      // the force is more than the model can take
};

// A contact by the local model and by the encoders, once the other checks are done.
struct ContactSample {
  struct Press {
    double depth = 0;                // by that of the scene [-]
    double force = 0;                // along the normal [N]
    double sigma = 0;                // rms that the force may be off by [N]
    double least = 0, greatest = 0;  // force of the model there [N]
  };
  // Of the first fingertip, if its force is valid; nullopt: not compared.
  std::optional<Press> press;
  // The first fingertip is where the encoders report it; nullopt: not compared.
  std::optional<bool> agrees_with_encoders;
  double apart = 0;  // force by the distance from there [N]
};

// Of its signals and their place, each sample, with a known force or without. Of failed checks with
// equal rank the first one added is reported.
Checks<FingertipSample> MakeFingertipChecks();
// Of its contact, after the others.
Checks<ContactSample> MakeContactChecks();

}  // namespace palpate
