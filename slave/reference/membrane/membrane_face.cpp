#include "slave/reference/membrane/membrane_face.h"

#include <algorithm>
#include <cmath>
#include <cstddef>
#include <numbers>

namespace palpate::simulation {
namespace {

using Eigen::Vector2d;
using Eigen::Vector3d;

constexpr int kDegree = DiscMesh::kAcross;

// Returns the shape functions of an element's side at its coordinate `x`, 0 to 1.
std::array<double, kDegree + 1> ShapesAt(double x) {
  std::array<double, kDegree + 1> shapes{};
  for (int i = 0; i <= kDegree; ++i) {
    double value = 1;
    for (int j = 0; j <= kDegree; ++j) {
      if (j != i) value *= (kDegree * x - j) / (i - j);
    }
    shapes[static_cast<std::size_t>(i)] = value;
  }
  return shapes;
}

}  // namespace

MembraneFace::MembraneFace(const DiscMesh& mesh, const Vector2d& p_O, double unit)
    : circles_(mesh.circles()),
      s_(mesh.circle_places()),
      rays_((mesh.ray_lines() - 1) * (mesh.is_quarter() ? 4 : 2)),
      quarter_(mesh.is_quarter()),
      unit_(unit) {
  if (!quarter_) axis_ = p_O.normalized();
}

Vector3d MembraneFace::Turned(const Vector3d& v) const {
  return {axis_.x() * v.x() - axis_.y() * v.y(), axis_.y() * v.x() + axis_.x() * v.y(), v.z()};
}

std::vector<Vector2d> MembraneFace::Nodes() const {
  std::vector<Vector2d> nodes;
  for (int circle = 0; circle < circles(); ++circle) {
    for (int ray = 0; ray < (circle == 0 ? 1 : rays_); ++ray) {
      const double angle = 2 * std::numbers::pi * ray / rays_;
      const Vector2d p = unit_ * circles_.At({s_[static_cast<std::size_t>(circle)], angle});
      nodes.push_back(Turned({p.x(), p.y(), 0}).head<2>());
    }
  }
  return nodes;
}

std::vector<std::array<int, 3>> MembraneFace::Triangles() const {
  std::vector<std::array<int, 3>> triangles;
  for (int circle = 0; circle + 1 < circles(); ++circle) {
    for (int ray = 0; ray < rays_; ++ray) {
      const int a = node(circle, ray), b = node(circle + 1, ray);
      const int c = node(circle + 1, ray + 1), d = node(circle, ray + 1);
      triangles.push_back({a, b, c});
      if (circle > 0) triangles.push_back({a, c, d});
    }
  }
  return triangles;
}

std::vector<MembraneFace::Source> MembraneFace::Sources() const {
  std::vector<Source> sources;
  for (int circle = 0; circle < circles(); ++circle) {
    for (int ray = 0; ray < (circle == 0 ? 1 : rays_); ++ray) {
      Source source{circle, ray};
      if (source.ray > rays_ / 2) {
        source.ray = rays_ - source.ray;
        source.y = -1;
      }
      if (quarter_ && source.ray > rays_ / 4) {
        source.ray = rays_ / 2 - source.ray;
        source.x = -1;
      }
      sources.push_back(source);
    }
  }
  return sources;
}

bool MembraneFace::Find(const Vector2d& p_O, Stencil* stencil) const noexcept {
  const Vector2d p = Vector2d(axis_.dot(p_O), axis_.x() * p_O.y() - axis_.y() * p_O.x()) / unit_;
  if (!(p.norm() <= circles_.radius)) return false;
  const auto place = circles_.Of(p);
  const double angle = place.angle < 0 ? place.angle + 2 * std::numbers::pi : place.angle;
  const double turn = angle / (2 * std::numbers::pi) * (rays_ / kDegree);  // in elements
  const int wedge = std::min(static_cast<int>(turn), rays_ / kDegree - 1);
  const double s = std::min(place.s, s_.back());
  int ring = 0;
  while (ring + kDegree + 1 < circles() && s > s_[static_cast<std::size_t>(ring + kDegree)]) {
    ring += kDegree;
  }
  const double inner = s_[static_cast<std::size_t>(ring)];
  const double outer = s_[static_cast<std::size_t>(ring + kDegree)];
  const auto across = ShapesAt((s - inner) / (outer - inner)), around = ShapesAt(turn - wedge);
  std::size_t k = 0;
  for (int i = 0; i <= kDegree; ++i) {
    for (int j = 0; j <= kDegree; ++j, ++k) {
      stencil->nodes[k] = node(ring + i, kDegree * wedge + j);
      stencil->weights[k] =
          across[static_cast<std::size_t>(i)] * around[static_cast<std::size_t>(j)];
    }
  }
  return true;
}

}  // namespace palpate::simulation
