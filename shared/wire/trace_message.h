// SampleTrace <-> that of palpate.v1.
#pragma once

#include <optional>
#include <string>

#include "palpate/v1/telemetry.pb.h"

#include "shared/state/sample_trace.h"

namespace palpate {

// Overwrites `message`. What did not happen is told as the stage before it.
void ToProto(const SampleTrace& trace, v1::SampleTrace* message);

// nullopt where `sensed_at` is absent or a number is not finite, negative or absurd; `reason` then
// says which.
std::optional<SampleTrace> FromProto(const v1::SampleTrace& message, std::string* reason);

}  // namespace palpate
