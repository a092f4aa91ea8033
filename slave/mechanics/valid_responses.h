// Invariants of a model's responses, for Validate in shared/validation.
#pragma once

#include <span>
#include <string>

#include "slave/mechanics/deformation_model.h"

namespace palpate {

// Checks responses: if one is not kFailed, its numbers must be finite and its errors not negative.
// If it is kValid, the stiffness of the contact alone must have no negative eigenvalue.
std::string FirstViolation(std::span<const ContactResponse> responses);

}  // namespace palpate
