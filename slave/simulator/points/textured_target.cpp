#include "slave/simulator/points/textured_target.h"

#include <cmath>
#include <numbers>
#include <optional>

namespace palpate::simulation {
namespace {

constexpr double kTexelsPerGrain = 5;
constexpr int kRings = 40;  // from the tip to the rim
constexpr int kAround = 160;

}  // namespace

Eigen::Vector3d HeartPath(double seconds, double pace) {
  constexpr double kReach = 0.010;  // [m]
  const double c = std::cos(pace * seconds), s = std::sin(pace * seconds);
  return kReach * Eigen::Vector3d(c, s, c + s);
}

TexturedTarget::TexturedTarget(const Shape& shape)
    : texture_(Texture::Speckle(shape.seed, kTexelsPerGrain, shape.grey, shape.contrast)) {
  // Uses polar coordinates about -z. The texture is mapped by arc length from the tip, so it is
  // hardly stretched.
  const double size = shape.semi_axes.head<2>().mean();
  const double texels = kTexelsPerGrain / shape.grain * size;  // per radian of the polar angle
  const auto add = [&](double polar, double turn) {
    const Eigen::Vector3d unit(std::sin(polar) * std::cos(turn), std::sin(polar) * std::sin(turn),
                               -std::cos(polar));
    const double bump = std::sin(9 * unit.x() + 1) * std::cos(8 * unit.y()) * std::cos(polar);
    p_B_.emplace_back(shape.semi_axes.cwiseProduct(unit) + shape.relief * bump * unit);
    on_texture_.emplace_back(texels * polar * std::cos(turn), texels * polar * std::sin(turn));
  };
  add(0, 0);
  for (int ring = 1; ring <= kRings; ++ring) {
    for (int k = 0; k < kAround; ++k) {
      add(std::numbers::pi / 2 * ring / kRings, 2 * std::numbers::pi * k / kAround);
    }
  }
  const auto vertex = [](int ring, int k) {
    return ring == 0 ? 0 : 1 + (ring - 1) * kAround + k % kAround;
  };
  for (int ring = 0; ring < kRings; ++ring) {
    for (int k = 0; k < kAround; ++k) {
      const int a = vertex(ring, k), b = vertex(ring + 1, k);
      const int c = vertex(ring + 1, k + 1), d = vertex(ring, k + 1);
      triangles_.push_back({a, b, c});
      if (ring > 0) triangles_.push_back({a, c, d});
    }
  }
}

void TexturedTarget::Draw(const Lens& lens, const Eigen::Isometry3d& X_CB, cv::Mat& canvas) const {
  std::vector<std::optional<Eigen::Vector2d>> p_I(p_B_.size());
  for (std::size_t i = 0; i < p_B_.size(); ++i) p_I[i] = Project(lens, X_CB * p_B_[i]);
  texture_.FillFacets(canvas, triangles_, p_I, on_texture_);
}

}  // namespace palpate::simulation
