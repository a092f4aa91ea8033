// The checks of one fingertip.
#pragma once

#include "slave/checks/check.h"
#include "slave/checks/fingertips/fingertip_sample.h"

namespace palpate {

// Of its signals and their place, each sample.
Checks<FingertipSample> MakeFingertipChecks();
// Of its contact, after the others.
Checks<ContactSample> MakeContactChecks();

}  // namespace palpate
