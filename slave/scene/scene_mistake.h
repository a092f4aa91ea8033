// A mistake in a scene as data.
#pragma once

#include <string>

namespace palpate {

// Reason why a scene cannot be used. Empty or 0: unknown. Text from the scene is shortened to 60
// characters.
struct SceneMistake {
  std::string key, value, message, expected;
  int line = 0;  // from 1
};

}  // namespace palpate
