// Invariants of a model's responses, for Validate in shared/validation.
#pragma once

#include <span>
#include <string>

#include "slave/mechanics/deformation_model.h"

namespace palpate {

// Where a response is not kFailed: its numbers are finite and its errors not negative. Where it is
// kValid, its own stiffness, that of one contact without the others, has no negative eigenvalue.
std::string FirstViolation(std::span<const ContactResponse> responses);

}  // namespace palpate
