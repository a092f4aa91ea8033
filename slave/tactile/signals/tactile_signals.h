// The signals of a fingertip: its readings minus their baseline, which differs from start to start
// (paper B, III.A.2).
#pragma once

#include "slave/capture/tactile_frame.h"

namespace palpate {

// E1 to E19, pac0, pdc: the order of the networks' inputs.
inline constexpr int kSignalCount = kElectrodeCount + 2;
// TactileSignals of other sensors contain c1 to cN and two zeros.
using TactileSignals = ShortList<double, kMaxChannels + 2, kSignalCount>;

}  // namespace palpate
