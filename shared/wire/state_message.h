// SlaveState and OperatorCommand <-> those of palpate.v1.
#pragma once

#include <optional>
#include <string>

#include "palpate/v1/state.pb.h"
#include "palpate/v1/telemetry.pb.h"

#include "shared/state/sample_trace.h"
#include "shared/state/slave_state.h"

namespace palpate {

// Largest message of a state with one planar contact [bytes].
inline constexpr std::size_t kMaxStateBytes = 256;

// Overwrites `message`. No NaN is sent: a force that is not finite becomes unknown (absent,
// VALIDITY_FAILED), and a local model that is not finite or has no plane becomes none. Fingers are
// sent if there is more than one, and the moment if it is known: a sender whose reader did not
// request it resets it before.
void ToProto(const SlaveState& state, v1::SlaveState* message);
// The fields of the estimate only.
void ToProto(const ContactEstimate& estimate, v1::SlaveState* message);

// Overwrites `message`; numbers that are not finite are sent as absent.
void ToProto(const CheckDetails& details, v1::CheckDetails* message);

// Returns nullopt if a required field is missing, or a number is not finite or out of range;
// `reason` then states the field and what is accepted. Fingers beyond kMaxFingers are ignored.
std::optional<SlaveState> FromProto(const v1::SlaveState& message, std::string* reason);

// Overwrites `message`, except fields that belong to the stream instead of the command:
// `operator_name`, `datagrams` and `details`.
void ToProto(const OperatorCommand& command, v1::OperatorCommand* message);

// Returns nullopt if a number is not finite or out of range, the sequence is 0, or an engaged
// command has no epoch or position; `reason` then states the field and what is accepted. An absent
// `sent_at` becomes Time{}, without an echo.
std::optional<OperatorCommand> FromProto(const v1::OperatorCommand& message, std::string* reason);

// Overwrites `message`. A missing time becomes that of the previous stage.
void ToProto(const SampleTrace& trace, v1::SampleTrace* message);

// Returns nullopt if `sensed_at` is absent, or a number is not finite, negative or out of range;
// `reason` then states which.
std::optional<SampleTrace> FromProto(const v1::SampleTrace& message, std::string* reason);

}  // namespace palpate
