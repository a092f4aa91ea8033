// Local contact model <-> PatchUpdate of palpate.v1.
#pragma once

#include <cstddef>
#include <optional>
#include <string>

#include "palpate/v1/patch.pb.h"

#include "shared/state/surface_patch.h"

namespace palpate {

// Largest message of a patch with its force-depth curve, and of a curve alone [bytes].
inline constexpr std::size_t kMaxPatchBytes = 64 * 1024, kMaxLawBytes = 256;

// Overwrite `message` with finite numbers.
void ToProto(const SurfacePatch& patch, v1::SurfacePatch* message);
void ToProto(const PatchLaw& law, v1::PatchLaw* message);

// Return nullopt if a field is missing, not finite, out of range, too many, or an invalid index;
// `reason` then states the field and what is accepted. A compliance is made positive semidefinite,
// because only that is passive.
std::optional<SurfacePatch> FromProto(const v1::SurfacePatch& message, std::string* reason);
std::optional<PatchLaw> FromProto(const v1::PatchLaw& message, std::string* reason);

}  // namespace palpate
