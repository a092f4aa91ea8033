// Invariants of the values that modules exchange. A violation is a fault of the program: with
// PALPATE_VALIDATE and in Debug it ends the program, other builds do not check.
#pragma once

#include <string>
#include <string_view>

#include "shared/mesh/solid_mesh.h"
#include "shared/state/slave_state.h"
#include "shared/state/surface_patch.h"

namespace palpate {

// The first invariant that does not hold, as "p_S_tip is not finite"; empty: all hold. Allocates
// only for a violation.
std::string FirstViolation(const ContactEstimate& estimate);
std::string FirstViolation(const SlaveState& state);
std::string FirstViolation(const OperatorCommand& command);
std::string FirstViolation(const SurfacePatch& patch);
std::string FirstViolation(const PatchLaw& law);
std::string FirstViolation(const SolidMesh& mesh);

// Returns whether this build validates.
bool IsValidating() noexcept;
// Prints place and violation, and aborts.
[[noreturn]] void EndOnViolation(std::string_view place, std::string_view violation) noexcept;

// `place`: the function whose result or argument it is.
template <class Value>
void Validate(const Value& value, std::string_view place) noexcept {
  if (!IsValidating()) return;
  if (const std::string violation = FirstViolation(value); !violation.empty())
    EndOnViolation(place, violation);
}

}  // namespace palpate
