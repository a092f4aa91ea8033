// The travelling model of the contact <-> PatchUpdate of palpate.v1.
#pragma once

#include <cstddef>
#include <optional>
#include <string>

#include "palpate/v1/patch.pb.h"

#include "shared/state/surface_patch.h"

namespace palpate {

// The longest that a patch with its law, and a law alone, may be on the wire [bytes].
inline constexpr std::size_t kMaxPatchBytes = 64 * 1024, kMaxLawBytes = 256;

// Overwrites `message`; everything is finite.
void ToProto(const SurfacePatch& patch, v1::SurfacePatch* message);
void ToProto(const PatchLaw& law, v1::PatchLaw* message);

// nullopt where something is missing, not finite, absurd, more than there may be or beside the
// surface; `reason` then says what and what is accepted. A compliance that is not positive
// semidefinite is made so: nothing else is a spring.
std::optional<SurfacePatch> FromProto(const v1::SurfacePatch& message, std::string* reason);
std::optional<PatchLaw> FromProto(const v1::PatchLaw& message, std::string* reason);

}  // namespace palpate
