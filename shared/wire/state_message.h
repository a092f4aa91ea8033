// SlaveState and OperatorCommand <-> those of palpate.v1.
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

// Overwrites `message`; numbers that are not finite are sent as absent.
void ToProto(const CheckDetails& details, v1::CheckDetails* message);

// nullopt where a needed field is missing or a number is not finite or absurd; `reason` then says
// which one and what is accepted. Of more than kMaxFingers fingers the first are read.
std::optional<SlaveState> FromProto(const v1::SlaveState& message, std::string* reason);

// Overwrites `message`. `operator_name` belongs to the stream, not to the command: whoever opens or
// serves one reads and writes it.
void ToProto(const OperatorCommand& command, v1::OperatorCommand* message);

// nullopt where a number is not finite or absurd, the sequence is 0, or an engaged command says no
// epoch or place; `reason` then says which one and what is accepted. An absent `sent_at` reads as
// Time{}: nothing to echo.
std::optional<OperatorCommand> FromProto(const v1::OperatorCommand& message, std::string* reason);

}  // namespace palpate
