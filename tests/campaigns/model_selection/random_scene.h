// Random scenes on which `auto` must choose a model. They resemble scenes that a user would write.
#pragma once

#include <cstdint>
#include <filesystem>

#include "slave/scene/scene.h"

namespace palpate::model_selection {

// The same seed gives the same scene on every machine. Consecutive seeds cycle through the kinds of
// objects: rectangle, box, membrane, disc, dome, polygon, polygon. Sizes, moduli, Poisson's ratio,
// tool, depth, tolerance and rate are random. Half of the planar objects are seen by a camera. The
// object has supports; model.kind is `auto`. A dome is a mesh file, which is written to `folder`.
Scene RandomScene(std::uint32_t seed, const std::filesystem::path& folder);

}  // namespace palpate::model_selection
