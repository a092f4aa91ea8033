#include "slave/mechanics/fem/held_motions.h"

#include <algorithm>

#include "shared/geometry/symmetric_eigen.h"

namespace palpate::fem {
namespace {

constexpr double kHolds =
    1e-13;  // smallest eigenvalue, relative to the largest; rounding makes 1e-15

}  // namespace

HeldMotions::Motions HeldMotions::Free() const {
  const SymmetricEigen eigen = EigenOf(gram_);
  const double largest = std::max(eigen.values[5], 1.0);
  return eigen.vectors.leftCols((eigen.values.array() < kHolds * largest).count());
}

}  // namespace palpate::fem
