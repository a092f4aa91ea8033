// A mistake in a scene as data.
#pragma once

#include <string>

namespace palpate {

// Why a scene cannot be used. Empty or 0: unknown. What the scene's author wrote is shortened to 60
// characters.
struct SceneMistake {
  std::string key, value, message, expected;
  int line = 0;  // from 1
};

}  // namespace palpate
