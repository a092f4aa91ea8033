// Where boundary elements carry their values: one, two or three nodes inside each element, at the
// points of Gauss's rule.
//
// Elements are discontinuous: no node is shared, none lies in a corner. At every node the boundary
// is smooth and has one normal, so that corners, the ends of what is held, contacts that begin
// between two elements, and any number of loops need no rule of their own; a contact on an element
// moves that element and no other. The price is two nodes per linear element where continuous ones
// have one. At Gauss's points the nodes' weights integrate a traction exactly, and displacements
// converge faster than the interpolation between the nodes does.
#pragma once

#include <array>
#include <cstddef>

#include "slave/scene/scene.h"

namespace palpate {

constexpr int kLargestNodeCount = 3;

// On -1 <= s <= 1. P_k: Legendre's polynomials.
struct ElementNodes {
  int count = 1;
  std::array<double, kLargestNodeCount> s{};
  std::array<double, kLargestNodeCount> weight{};  // sum: 1
  // The basis function of node m, one there and zero at the others, is sum_k mode[m][k] P_k(s).
  std::array<std::array<double, kLargestNodeCount>, kLargestNodeCount> mode{};

  // The basis function of node m at an end of the element, -1 or 1, where P_k is end^k.
  [[nodiscard]] double AtEnd(std::size_t m, double end) const {
    return mode[m][0] + end * mode[m][1] + mode[m][2];
  }

  static const ElementNodes& Of(ElementOrder order);
};

}  // namespace palpate
