#include "slave/mechanics/fem/zone/near/matrix_times.h"

#include <array>

#include "slave/mechanics/linear/lanes.h"

namespace palpate {
namespace {

// Two places at a time: y is read and written half as often.
PALPATE_DISPATCHED void AddSixColumns(const float* a, const float* d, int rows, const float* x,
                                      const float* z, float* __restrict y) {
  const float *b = a + rows, *c = b + rows, *e = d + rows, *f = e + rows;
  const float x0 = x[0], x1 = x[1], x2 = x[2], z0 = z[0], z1 = z[1], z2 = z[2];
  for (int i = 0; i < rows; ++i) {
    y[i] += (x0 * a[i] + x1 * b[i] + x2 * c[i]) + (z0 * d[i] + z1 * e[i] + z2 * f[i]);
  }
}

}  // namespace

void AddPlaces(const Eigen::MatrixXf& a, std::span<const int> places, const Eigen::VectorXf& x,
               Eigen::VectorXf* y) noexcept {
  constexpr std::array<float, 3> kNothing{};
  const auto rows = static_cast<int>(a.rows());
  for (std::size_t k = 0; k < places.size(); k += 2) {
    const bool two = k + 1 < places.size();
    const long n = places[k], m = two ? places[k + 1] : n;
    AddSixColumns(a.data() + 3 * n * rows, a.data() + 3 * m * rows, rows, x.data() + 3 * n,
                  two ? x.data() + 3 * m : kNothing.data(), y->data());
  }
}

}  // namespace palpate
