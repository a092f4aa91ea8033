// Scenes drawn at random, for `auto` to decide: what a person might write, not what is easy.
#pragma once

#include <cstdint>
#include <filesystem>

#include "slave/scene/scene.h"

namespace palpate::model_selection {

// The same for the same seed everywhere. Seeds in a row go through the kinds of objects: rectangle,
// box, membrane, disc, dome, polygon, polygon; sizes, moduli, Poisson's ratio, tool, depth,
// tolerance and rate are drawn. Half of the planar objects are before a camera. Held, with
// model.kind `auto`. A dome is a mesh file, written to `folder`.
Scene RandomScene(std::uint32_t seed, const std::filesystem::path& folder);

}  // namespace palpate::model_selection
