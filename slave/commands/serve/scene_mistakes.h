// Mistakes of a proposed scene, as data for its author.
#pragma once

#include <exception>
#include <string>
#include <vector>

#include "slave/scene/scene_loader.h"
#include "slave/scene/scene_mistake.h"

namespace palpate {

// The mistakes of a scene that cannot be read.
std::vector<SceneMistake> MistakesOf(const SceneError& error);

// The mistake that a message of another exception states: `key = value: message: expected ...`, or
// a sentence with a key in it. At most 600 characters of each part.
SceneMistake MistakeIn(const std::string& message);

// One line each, at most 20.
std::string InWords(const std::vector<SceneMistake>& mistakes);

}  // namespace palpate
