// Changes of a scene: true ones, or statements that differ from the truth.
#pragma once

#include <nlohmann/json.hpp>

#include "slave/scene/scene.h"

namespace palpate::campaign {

// `edits`: pairs of a name and a value. Throws std::invalid_argument: unknown name.
void Edit(const nlohmann::json& edits, Scene* scene);

}  // namespace palpate::campaign
