// SampleTrace <-> that of palpate.v1.
#pragma once

#include <optional>
#include <string>

#include "palpate/v1/telemetry.pb.h"

#include "shared/state/sample_trace.h"

namespace palpate {

// Overwrites `message`. A missing time becomes that of the previous stage.
void ToProto(const SampleTrace& trace, v1::SampleTrace* message);

// Returns nullopt if `sensed_at` is absent, or a number is not finite, negative or out of range;
// `reason` then states which.
std::optional<SampleTrace> FromProto(const v1::SampleTrace& message, std::string* reason);

}  // namespace palpate
