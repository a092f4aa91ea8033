// SlaveState <-> palpate.v1.SlaveState.
#pragma once

#include <optional>
#include <string>

#include "palpate/v1/state.pb.h"

#include "shared/state/slave_state.h"

namespace palpate {

// The longest a state of one planar contact may be on the wire [bytes].
inline constexpr std::size_t kMaxStateBytes = 256;

// Overwrites `message`. A force that is not finite is sent as unknown (absent, VALIDITY_FAILED), a
// local model that is not finite or has no plane as none: no NaN goes out. Fingers are sent where
// there is more than one.
void ToProto(const SlaveState& state, v1::SlaveState* message);

// nullopt where a needed field is missing or a number is not finite or absurd; `reason` then says
// which one and what is accepted. Of more than kMaxFingers fingers the first are read.
std::optional<SlaveState> FromProto(const v1::SlaveState& message, std::string* reason);

}  // namespace palpate
