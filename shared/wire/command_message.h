// OperatorCommand <-> palpate.v1.OperatorCommand. `operator_name` belongs to the stream, not to the
// command: whoever opens or serves one reads and writes it.
#pragma once

#include <optional>
#include <string>

#include "palpate/v1/state.pb.h"

#include "shared/state/slave_state.h"

namespace palpate {

// Overwrites `message`.
void ToProto(const OperatorCommand& command, v1::OperatorCommand* message);

// nullopt where a number is not finite or absurd, the sequence is 0, or an engaged command says no
// epoch or place; `reason` then says which one and what is accepted. An absent `sent_at` reads as
// Time{}: nothing to echo.
std::optional<OperatorCommand> FromProto(const v1::OperatorCommand& message, std::string* reason);

}  // namespace palpate
