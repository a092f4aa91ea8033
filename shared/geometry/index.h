// Meshes, elements and unknowns are counted with int, which may be subtracted; containers are asked
// with std::size_t.
#pragma once

#include <cstddef>

namespace palpate {

// i >= 0
constexpr std::size_t Index(int i) {
  return static_cast<std::size_t>(i);
}

}  // namespace palpate
