#include "slave/simulator/points/painted_membrane.h"

#include <cmath>
#include <cstddef>
#include <numbers>
#include <optional>
#include <vector>

#include <opencv2/core.hpp>

#include "slave/simulator/environment/painting.h"
#include "slave/vision/dots/dot_layout.h"

namespace palpate::simulation {
namespace {

using Eigen::Vector2d;
using Eigen::Vector3d;

constexpr int kRimCorners = 720;

constexpr int kCorners = 32;  // corners of a dot's outline
// Distance from a dot's centre at which the tilt is evaluated, in radii.
constexpr double kNearby = 0.05;

constexpr int kCells = 72;  // cells across the membrane
constexpr double kTexelsPerGrain = 5;
constexpr float kGrey = 120, kContrast = 90;

}  // namespace

Eigen::Vector3d MembraneView::Place(const Eigen::Vector2d& p_O,
                                    const Indentation& indentation) const {
  return Eigen::Vector3d(p_O.x(), p_O.y(), -thickness) + DisplacementOf(indentation, p_O);
}

cv::Mat MembraneView::PlainFace() const {
  std::vector<Eigen::Vector2d> rim;
  for (int k = 0; k < kRimCorners; ++k) {
    const double angle = 2 * std::numbers::pi * k / kRimCorners;
    const Eigen::Vector3d p_O(radius * std::cos(angle), radius * std::sin(angle), -thickness);
    const auto p_I = Project(lens, X_CO * p_O);
    if (p_I) rim.push_back(*p_I);
  }
  return kBeyond + (kRubber - kBeyond) * CoverageOf({rim}, {0, 0, lens.size[0], lens.size[1]});
}

PrintedDots DotsOn(const PointTracking& points) {
  return {DotPlaces(points), points.dot_radius};
}

DottedMembrane::DottedMembrane(const MembraneView& view, const PrintedDots& dots,
                               const Exposure& exposure)
    : view_(view), dots_(dots), exposure_(exposure), ground_(view.PlainFace()) {
  exposure_.Blur(ground_);
}

// The polygon has the area of its disc, because an inscribed one would be smaller.
bool DottedMembrane::Outline(const Vector2d& p_O, const Indentation& indentation,
                             std::vector<Vector2d>* outline) const {
  const double nearby = kNearby * dots_.radius, turn = 2 * std::numbers::pi / kCorners;
  const auto along = [&](const Vector2d& way) -> Vector3d {
    return view_.Place(p_O + nearby * way, indentation) -
           view_.Place(p_O - nearby * way, indentation);
  };
  const Vector3d x = along({1, 0}).normalized(), n = x.cross(along({0, 1})).normalized();
  const Vector3d y = n.cross(x), middle = view_.Place(p_O, indentation);
  const double corner = dots_.radius * std::sqrt(turn / std::sin(turn));
  outline->clear();
  for (int k = 0; k < kCorners; ++k) {
    const Vector3d p = middle + corner * (std::cos(k * turn) * x + std::sin(k * turn) * y);
    const auto p_I = Project(view_.lens, view_.X_CO * p);
    if (!p_I) return false;
    outline->push_back(*p_I);
  }
  return true;
}

// Blur is linear, and dots do not overlap, so the blurred coverage is subtracted from the blurred
// ground.
const cv::Mat& DottedMembrane::Paint(const Indentation& indentation) {
  ground_.copyTo(seen_);
  std::vector<Vector2d> outline;
  for (const Vector2d& p_O : dots_.places_O) {
    if (!Outline(p_O, indentation, &outline)) continue;
    const cv::Rect window = WindowAround(outline, exposure_.reach() + 1, seen_.size());
    if (window.empty()) continue;
    cv::Mat covered = CoverageOf({outline}, window);
    exposure_.Blur(covered);
    cv::Mat part = seen_(window);
    part += (kDot - MembraneView::kRubber) * covered;
  }
  return seen_;
}

TexturedMembrane::TexturedMembrane(const MembraneView& view, std::uint32_t seed,
                                   const Exposure& exposure)
    : view_(view),
      exposure_(exposure),
      texture_(Texture::Speckle(seed + 7, kTexelsPerGrain, kGrey, kContrast)),
      ground_(view.PlainFace()) {
  LayGrid();
}

// A square grid, mapped onto the disc so that its edge becomes the rim: rings of the square become
// circles (Shirley and Chiu 1997, without their equal areas).
void TexturedMembrane::LayGrid() {
  const double texels = kGrains * kTexelsPerGrain / (2 * view_.radius);  // per metre
  for (int j = 0; j <= kCells; ++j) {
    for (int i = 0; i <= kCells; ++i) {
      const Vector2d square(2.0 * i / kCells - 1, 2.0 * j / kCells - 1);
      const double ring = square.cwiseAbs().maxCoeff();
      const Vector2d disc = ring > 0 ? Vector2d(ring * square.normalized()) : Vector2d(0, 0);
      nodes_O_.push_back(view_.radius * disc);
      on_texture_.push_back(texels * nodes_O_.back());
    }
  }
  const auto node = [](int i, int j) { return j * (kCells + 1) + i; };
  for (int j = 0; j < kCells; ++j) {
    for (int i = 0; i < kCells; ++i) {
      triangles_.push_back({node(i, j), node(i + 1, j), node(i + 1, j + 1)});
      triangles_.push_back({node(i, j), node(i + 1, j + 1), node(i, j + 1)});
    }
  }
}

const cv::Mat& TexturedMembrane::Paint(const Indentation& indentation) {
  ground_.copyTo(seen_);
  std::vector<std::optional<Vector2d>> p_I;
  p_I.reserve(nodes_O_.size());
  for (const Vector2d& p_O : nodes_O_)
    p_I.push_back(Project(view_.lens, view_.X_CO * view_.Place(p_O, indentation)));
  texture_.FillFacets(seen_, triangles_, p_I, on_texture_);
  exposure_.Blur(seen_);
  return seen_;
}

}  // namespace palpate::simulation
