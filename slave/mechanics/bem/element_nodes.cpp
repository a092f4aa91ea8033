#include "slave/mechanics/bem/element_nodes.h"

#include <cmath>
#include <cstddef>

namespace palpate {
namespace {

double Legendre(std::size_t k, double s) {
  return k == 0 ? 1 : k == 1 ? s : 1.5 * s * s - 0.5;
}

// The nodes integrate products of two basis functions exactly: a function's component along P_k is
// its weighted sum over the nodes, times 2 k + 1.
ElementNodes WithModes(ElementNodes nodes) {
  for (std::size_t m = 0; m < static_cast<std::size_t>(nodes.count); ++m) {
    for (std::size_t k = 0; k < static_cast<std::size_t>(nodes.count); ++k) {
      nodes.mode[m][k] =
          (2 * static_cast<double>(k) + 1) * nodes.weight[m] * Legendre(k, nodes.s[m]);
    }
  }
  return nodes;
}

}  // namespace

const ElementNodes& ElementNodes::Of(ElementOrder order) {
  static const double third = 1 / std::sqrt(3.0);
  static const double fifth = std::sqrt(0.6);
  static const ElementNodes constant = WithModes({1, {0}, {1}, {}});
  static const ElementNodes linear = WithModes({2, {-third, third}, {0.5, 0.5}, {}});
  static const ElementNodes quadratic =
      WithModes({3, {-fifth, 0, fifth}, {5.0 / 18, 8.0 / 18, 5.0 / 18}, {}});
  return order == ElementOrder::kConstant ? constant
         : order == ElementOrder::kLinear ? linear
                                          : quadratic;
}

}  // namespace palpate
