#include "slave/mechanics/fem/zone/matrix_times.h"

#include "slave/mechanics/linear/lanes.h"

namespace palpate {
namespace {

PALPATE_DISPATCHED void AddThreeColumns(const float* a, int rows, const float* x,
                                        float* __restrict y) {
  const float *b = a + rows, *c = b + rows;
  const float x0 = x[0], x1 = x[1], x2 = x[2];
  for (int i = 0; i < rows; ++i) y[i] += x0 * a[i] + x1 * b[i] + x2 * c[i];
}

}  // namespace

void AddPlaces(const Eigen::MatrixXf& a, std::span<const int> places, const Eigen::VectorXf& x,
               Eigen::VectorXf* y) noexcept {
  const auto rows = static_cast<int>(a.rows());
  for (const int n : places) {
    AddThreeColumns(a.data() + 3L * n * rows, rows, x.data() + 3L * n, y->data());
  }
}

}  // namespace palpate
