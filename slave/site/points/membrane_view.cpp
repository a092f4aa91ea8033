#include "slave/site/points/membrane_view.h"

#include <cmath>
#include <numbers>
#include <vector>

#include <opencv2/core.hpp>

#include "slave/site/coverage.h"

namespace palpate::site {
namespace {

constexpr int kRimCorners = 720;

}  // namespace

Eigen::Vector3d MembraneView::Place(const Eigen::Vector2d& p_O, const Dent& dent) const {
  return Eigen::Vector3d(p_O.x(), p_O.y(), -thickness) + DisplacementOf(dent, p_O);
}

cv::Mat MembraneView::PlainFace() const {
  std::vector<Eigen::Vector2d> rim;
  for (int k = 0; k < kRimCorners; ++k) {
    const double angle = 2 * std::numbers::pi * k / kRimCorners;
    const Eigen::Vector3d p_O(radius * std::cos(angle), radius * std::sin(angle), -thickness);
    const auto p_I = Project(lens, X_CO * p_O);
    if (p_I) rim.push_back(*p_I);
  }
  Coverage coverage({0, 0, lens.size[0], lens.size[1]});
  coverage.Add(rim);
  cv::Mat face;
  coverage.Resolve(face);
  face = kBeyond + (kRubber - kBeyond) * face;
  return face;
}

}  // namespace palpate::site
