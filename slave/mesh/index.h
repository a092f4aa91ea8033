// Converts int to std::size_t. Counts of nodes, elements and unknowns are int, so that differences
// are safe. Containers use std::size_t.
#pragma once

#include <cstddef>

namespace palpate {

// i >= 0
constexpr std::size_t Index(int i) {
  return static_cast<std::size_t>(i);
}

}  // namespace palpate
