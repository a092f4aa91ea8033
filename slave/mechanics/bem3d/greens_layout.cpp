#include "slave/mechanics/bem3d/greens_layout.h"

#include <stdexcept>

#include "shared/geometry/index.h"
#include "slave/mechanics/linear/dense_lu.h"

namespace palpate {
namespace {

constexpr double kLargestCondition = 1e13;
constexpr double kDiscretisation = 1;  // rises whenever the same inputs give another result

}  // namespace

GreensLayout::GreensLayout(const ReferenceSystem& system) {
  for (int i = 0; i < system.triangles(); ++i) {
    for (int c = 0; c < 3; ++c) {
      row_.push_back(system.held(i, c) ? static_cast<int>(rows_++) : -1);
    }
  }
}

std::vector<double> GreensLayout::Inputs(const ReferenceSystem& system) {
  std::vector<double> inputs{kDiscretisation, double{DenseLu::kWidth}, double{kTriangles},
                             system.nu()};
  for (int i = 0; i < system.triangles(); ++i) {
    for (const auto& corner : system.surface().elements[Index(i)].corners) {
      inputs.insert(inputs.end(), corner.begin(), corner.end());
    }
    for (int c = 0; c < 3; ++c) inputs.push_back(system.held(i, c) ? 1 : 0);
  }
  return inputs;
}

void GreensLayout::Split(const Eigen::Ref<const Eigen::MatrixXd>& columns, double* blocks,
                         double* reactions) const {
  for (Eigen::Index k = 0; k < columns.cols(); ++k) {
    const auto column = static_cast<std::size_t>(k);
    double* block = blocks + 9 * places() * (column / 3) + 3 * (column % 3);
    double* reaction = reactions + column * rows_;
    for (std::size_t row = 0; row < row_.size(); ++row) {
      const double value = columns(static_cast<Eigen::Index>(row), k);
      const bool held = row_[row] >= 0;
      block[9 * (row / 3) + row % 3] = held ? 0 : value;
      if (held) reaction[row_[row]] = value;
    }
  }
}

void RequireRegular(double condition) {
  if (!(condition < kLargestCondition)) RefuseSingular();
}

void RefuseSingular() {
  throw std::invalid_argument(
      "the boundary element system is singular (condition > 1e13): the surface touches itself, or "
      "its triangles differ too much in size");
}

}  // namespace palpate
