#include "slave/tactile/training/normal_axes.h"

#include <algorithm>
#include <array>
#include <stdexcept>
#include <string_view>
#include <vector>

#include <Eigen/LU>

namespace palpate {
namespace {

std::vector<Eigen::Matrix3d> AllAxes() {
  std::vector<Eigen::Matrix3d> all;
  std::array<int, 3> order{0, 1, 2};
  do {
    for (int signs = 0; signs < 8; ++signs) {
      Eigen::Matrix3d axes = Eigen::Matrix3d::Zero();
      for (int row = 0; row < 3; ++row) {
        axes(row, order[static_cast<std::size_t>(row)]) = (signs >> row) % 2 == 0 ? 1 : -1;
      }
      all.push_back(axes);
    }
  } while (std::ranges::next_permutation(order).found);
  return all;
}

}  // namespace

std::string AxesText(const Eigen::Matrix3d& axes) {
  std::string text;
  for (int row = 0; row < 3; ++row) {
    if (row > 0) text += ',';
    Eigen::Index column = 0;
    axes.row(row).cwiseAbs().maxCoeff(&column);
    if (axes(row, column) < 0) text += '-';
    text += "xyz"[column];
  }
  return text;
}

Eigen::Matrix3d ParseAxes(const std::string& text) {
  for (const Eigen::Matrix3d& axes : AllAxes()) {
    if (AxesText(axes) == text) return axes;
  }
  throw std::invalid_argument(text + ": accepted is three different axes like x,y,z or -x,y,-z");
}

Eigen::Matrix3d NearestAxes(const Eigen::Matrix3d& rotation) {
  Eigen::Matrix3d nearest = Eigen::Matrix3d::Identity();
  for (const Eigen::Matrix3d& axes : AllAxes()) {
    const bool nearer = axes.cwiseProduct(rotation).sum() > nearest.cwiseProduct(rotation).sum();
    if (axes.determinant() > 0 && nearer) nearest = axes;
  }
  return nearest;
}

}  // namespace palpate
