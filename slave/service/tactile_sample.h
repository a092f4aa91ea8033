// palpate.v1.TactileSample -> FingerReading.
#pragma once

#include <optional>
#include <string>

#include "palpate/v1/state.pb.h"

#include "slave/capture/tactile_frame.h"

namespace palpate {

struct TactileSample {
  Time sensed_at{};  // sender's clock
  FingerReading reading;
};

// nullopt: another number of electrodes than 19 or of pressures than at most two, no stamp, half a
// pose or none that is one; `reason` then says which and what is accepted. Whether counts are
// finite is left to whoever takes them.
std::optional<TactileSample> FromProto(const v1::TactileSample& message, std::string* reason);

}  // namespace palpate
