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

  // The basis function of node m in the middle of the element, where P_2 is -1/2 and P_1 zero.
  [[nodiscard]] double AtMidpoint(std::size_t m) const { return mode[m][0] - 0.5 * mode[m][2]; }

  static const ElementNodes& Of(ElementOrder order);
};

}  // namespace palpate
