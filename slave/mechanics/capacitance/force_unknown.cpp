#include "slave/mechanics/capacitance/force_unknown.h"

#include <cstddef>

namespace palpate {

Eigen::Matrix3d FullBlock(const ForceUnknown& at, const ForceUnknown& by) {
  Eigen::Matrix3d sum = Eigen::Matrix3d::Zero();
  for (int b = 0; b < by.share_count; ++b) {
    const auto& from = by.shares[static_cast<std::size_t>(b)];
    for (int a = 0; a < at.share_count; ++a) {
      const auto& to = at.shares[static_cast<std::size_t>(a)];
      sum += to.weight * from.weight * BlockAt(from.column, to.place);
    }
  }
  return sum;
}

}  // namespace palpate
