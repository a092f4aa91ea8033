#include "slave/mechanics/bem3d/corner_fit.h"

#include <algorithm>
#include <cstddef>
#include <utility>

#include <Eigen/Eigenvalues>

namespace palpate {
namespace {

using Eigen::Matrix3d;
using Eigen::Vector3d;

// What extrapolation along one direction may add to the sum of the squared weights.
constexpr double kMostExtrapolation = 1;
// Mean square extent along a direction, of the largest: the triangles lie in a plane.
constexpr double kFlat = 1e-12;

struct Fit {
  CornerFit::Shares shares;
  bool exact = true;  // for whatever is linear in space
};

// Weights 1 / n - d_m^T S^+ d with the offsets d_m from the mean place, S = sum d_m d_m^T and the
// mean's own offset d from the node: the value of the regression there.
Fit FitAt(const Vector3d& node, const std::vector<int>& star, const ClosedSurface& surface) {
  const auto place = [&](int i) { return surface.elements[static_cast<std::size_t>(i)].centroid; };
  Vector3d mean = Vector3d::Zero();
  for (const int i : star) mean += place(i) / static_cast<double>(star.size());
  Matrix3d S = Matrix3d::Zero();
  for (const int i : star) S += (place(i) - mean) * (place(i) - mean).transpose();
  const Eigen::SelfAdjointEigenSolver<Matrix3d> eigen(S);
  const double flat = kFlat * eigen.eigenvalues()[2];
  Fit fit;
  Vector3d slope = Vector3d::Zero();
  for (int k = 0; k < 3; ++k) {
    const Vector3d direction = eigen.eigenvectors().col(k);
    const double extent = eigen.eigenvalues()[k];
    const double offset = direction.dot(mean - node);
    if (extent > flat && offset * offset <= kMostExtrapolation * extent) {
      slope += offset / extent * direction;
    } else if (offset * offset > flat) {
      fit.exact = false;
    }
  }
  for (const int i : star) {
    fit.shares.push_back(
        {i, 1.0 / static_cast<double>(star.size()) - (place(i) - mean).dot(slope)});
  }
  return fit;
}

}  // namespace

CornerFit::CornerFit(const SurfaceMesh& mesh, const ClosedSurface& surface) {
  NumberCorners(mesh);
  std::vector<std::vector<int>> at(shares_.size());  // triangles by node
  std::vector<Vector3d> places(shares_.size());
  for (int i = 0; i < surface.size(); ++i) {
    for (std::size_t k = 0; k < 3; ++k) {
      const auto node = static_cast<std::size_t>(corners(i)[k]);
      at[node].push_back(i);
      places[node] = surface.elements[static_cast<std::size_t>(i)].corners[k];
    }
  }
  for (std::size_t node = 0; node < at.size(); ++node) {
    Fit fit = FitAt(places[node], at[node], surface);
    if (!fit.exact) {
      std::vector<int> wider;
      for (const int i : at[node]) {
        for (const int corner : corners(i)) {
          const auto& around = at[static_cast<std::size_t>(corner)];
          wider.insert(wider.end(), around.begin(), around.end());
        }
      }
      std::ranges::sort(wider);
      wider.erase(std::ranges::unique(wider).begin(), wider.end());
      fit = FitAt(places[node], wider, surface);
    }
    shares_[node] = std::move(fit.shares);
  }
}

void CornerFit::NumberCorners(const SurfaceMesh& mesh) {
  std::vector<int> number(mesh.nodes.size(), -1);
  int count = 0;
  for (const auto& triangle : mesh.triangles) {
    auto& corners = corners_.emplace_back();
    for (std::size_t k = 0; k < 3; ++k) {
      int& node = number[static_cast<std::size_t>(triangle[k])];
      if (node < 0) node = count++;
      corners[k] = node;
    }
  }
  shares_.resize(static_cast<std::size_t>(count));
}

}  // namespace palpate
