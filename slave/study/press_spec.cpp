#include "slave/study/press_spec.h"

#include <algorithm>
#include <limits>
#include <optional>
#include <stdexcept>
#include <variant>

#include <Eigen/Geometry>

#include "shared/mesh/disc_patch.h"
#include "shared/mesh/solid_mesh.h"
#include "slave/mechanics/factory/make_model.h"
#include "slave/mechanics/factory/tool_press.h"
#include "slave/mechanics/object_mesh.h"
#include "slave/mesh/index.h"
#include "slave/study/volume_force.h"

namespace palpate::study {
namespace {

using Eigen::Vector2d;
using Eigen::Vector3d;

constexpr double kMembraneLinear = 0.01;  // of the thickness: von Karman's correction is 1e-4 there
constexpr double kToolPerSize = 1.0 / 15;
constexpr double kDefaultDepth = 0.05;  // of the object's size

// The nearest point of the outline, with the body on the left of its edge.
Press NearestOnOutline(const Outline& outline, const Vector2d& p) {
  Press press;
  double nearest = std::numeric_limits<double>::infinity();
  const auto look = [&](const std::vector<Vector2d>& loop, bool reversed) {
    for (std::size_t i = 0; i < loop.size(); ++i) {
      Vector2d a = loop[i], b = loop[(i + 1) % loop.size()];
      if (reversed) std::swap(a, b);
      const Vector2d edge = b - a;
      const double t = std::clamp((p - a).dot(edge) / edge.squaredNorm(), 0.0, 1.0);
      const Vector2d on_edge = a + t * edge;
      const double distance = (on_edge - p).norm();
      if (!(distance < nearest)) continue;
      nearest = distance;
      const Vector2d along = edge.normalized();
      press.p_O = {on_edge.x(), on_edge.y(), 0};
      press.along_O = {along.x(), along.y(), 0};
      press.inward_O = {-along.y(), along.x(), 0};
    }
  };
  look(outline.outer, SignedArea(outline.outer) < 0);
  for (const auto& hole : outline.holes) look(hole, SignedArea(hole) > 0);
  return press;
}

Press OnMembrane(const Vector3d& p_O) {
  return {p_O, -Vector3d::UnitZ(), Vector3d::UnitX()};
}

// Returns the press below home, or at the centre if home is not above the membrane.
Press UnderHome(const Scene& scene, double radius) {
  const Vector3d home_O = scene.object.X_SO.inverse() * scene.manipulator.home;
  const bool over = home_O.head<2>().norm() < radius;
  return OnMembrane(over ? Vector3d(home_O.x(), home_O.y(), 0) : Vector3d::Zero());
}

Press OnTriangle(const SurfaceMesh& surface, int triangle, const Vector3d& p_O) {
  const auto& corners = surface.triangles[Index(triangle)];
  const Vector3d edge = surface.nodes[Index(corners[1])] - surface.nodes[Index(corners[0])];
  return {p_O, -Normal(surface, triangle), edge.normalized()};
}

// Returns where the ray leaves the surface last; nullopt: it does not intersect it.
std::optional<Press> LastExit(const SurfaceMesh& surface, const Vector3d& from,
                              const Vector3d& way) {
  std::optional<Press> exit;
  double farthest = 0;
  constexpr double kEdgeSlack = 1e-9;
  for (int t = 0; t < static_cast<int>(surface.triangles.size()); ++t) {
    const auto& c = surface.triangles[Index(t)];
    Eigen::Matrix3d system;
    const Vector3d& a = surface.nodes[Index(c[0])];
    system << surface.nodes[Index(c[1])] - a, surface.nodes[Index(c[2])] - a, -way;
    const double volume = system.col(0).cross(system.col(1)).dot(system.col(2));
    if (volume == 0) continue;
    const Vector3d r = from - a;
    const double u = r.cross(system.col(1)).dot(system.col(2)) / volume;
    const double v = system.col(0).cross(r).dot(system.col(2)) / volume;
    const double s = system.col(0).cross(system.col(1)).dot(r) / volume;
    if (u < -kEdgeSlack || v < -kEdgeSlack || u + v > 1 + kEdgeSlack || s <= farthest) continue;
    farthest = s;
    exit = OnTriangle(surface, t, from + s * way);
  }
  return exit;
}

Press OppositeToHeld(const Scene& scene, const SurfaceMesh& surface) {
  const auto held = FixedNodeDofs(scene, surface.nodes);
  Eigen::AlignedBox3d box;
  Vector3d held_sum = Vector3d::Zero();
  int held_count = 0;
  for (std::size_t i = 0; i < held.size(); ++i) {
    box.extend(surface.nodes[i]);
    if (!held[i][0] && !held[i][1] && !held[i][2]) continue;
    held_sum += surface.nodes[i];
    ++held_count;
  }
  const Vector3d centre = box.center();
  Vector3d way = held_count > 0 ? Vector3d(centre - held_sum / held_count) : Vector3d::UnitZ();
  if (way.norm() < 1e-6 * box.sizes().norm()) way = Vector3d::UnitZ();
  const auto press = LastExit(surface, centre, way.normalized());
  if (!press) {
    throw std::invalid_argument(
        "study: no surface lies opposite to the fixed part: expected study.contacts with a "
        "point");
  }
  return *press;
}

std::vector<Press> OnVolume(const Scene& scene, const SurfaceMesh& surface,
                            const std::vector<Vector3d>& places) {
  if (places.empty()) return {OppositeToHeld(scene, surface)};
  std::vector<Press> presses;
  for (const Vector3d& p_O : places) {
    const auto found = FindPlace(surface, p_O);
    if (!found || found->triangle < 0) {
      throw std::invalid_argument(
          "study.contacts: a point off the surface: expected a point on it");
    }
    presses.push_back(OnTriangle(surface, found->triangle, p_O));
  }
  return presses;
}

std::vector<Press> OnOutline(const Scene& scene, const Outline& outline,
                             const std::vector<Vector3d>& places) {
  const Vector3d home_O = scene.object.X_SO.inverse() * scene.manipulator.home;
  if (places.empty()) return {NearestOnOutline(outline, home_O.head<2>())};
  std::vector<Press> presses;
  for (const Vector3d& p_O : places) presses.push_back(NearestOnOutline(outline, p_O.head<2>()));
  return presses;
}

using Eigen::Matrix3d;

constexpr int kDepth = 6;          // halvings of an edge
constexpr double kSameSide = 0.5;  // cosine between normals, as in contact patches

// Cut is the intersection of a triangle with a ball.
class Cut {
 public:
  // `corners`: columns; `area` [m^2].
  Cut(const Matrix3d& corners, double area, const Vector3d& centre, double radius)
      : corners_(corners), centre_(centre), radius_(radius) {
    Add(Matrix3d::Identity(), area, 0);
  }
  // Integral of l l^T, l the barycentric coordinates, over the part of the triangle in the ball
  // [m^2]. The sum of all entries is the area, since coordinates sum up to 1.
  [[nodiscard]] const Matrix3d& moment() const { return moment_; }

 private:
  // `piece`: the coordinates of its corners as columns.
  void Add(const Matrix3d& piece, double area, int depth) {
    const Vector3d middle = piece.rowwise().mean();
    double reach = 0;
    bool whole = true;
    for (int i = 0; i < 3; ++i) {
      reach = std::max(reach, (corners_ * (piece.col(i) - middle)).norm());
      whole = whole && Distance(piece.col(i)) <= radius_;
    }
    const double distance = Distance(middle);
    if (distance > radius_ + reach) return;
    Matrix3d middles;  // of the edges
    for (int i = 0; i < 3; ++i) middles.col(i) = 0.5 * (piece.col(i) + piece.col((i + 1) % 3));
    if (!whole && depth < kDepth) {
      for (int i = 0; i < 3; ++i) {
        Matrix3d quarter;
        quarter << piece.col(i), middles.col(i), middles.col((i + 2) % 3);
        Add(quarter, area / 4, depth + 1);
      }
      Add(middles, area / 4, depth + 1);
    } else if (whole || distance <= radius_) {
      moment_ += area / 3 * middles * middles.transpose();  // exact: l l^T is quadratic
    }
  }
  [[nodiscard]] double Distance(const Vector3d& l) const { return (corners_ * l - centre_).norm(); }

  const Matrix3d& corners_;
  const Vector3d& centre_;
  double radius_;
  Matrix3d moment_ = Matrix3d::Zero();
};

}  // namespace

PressSpec AskedOf(const Scene& scene, const std::vector<Vector3d>& asked_places) {
  const std::vector<Vector3d>& places = asked_places.empty() ? scene.study_contacts : asked_places;
  PressSpec question;
  double small_depth = 0;
  if (const auto* membrane = std::get_if<MembraneGeometry>(&scene.object.geometry)) {
    question.size = membrane->radius;
    small_depth = kMembraneLinear * membrane->thickness;
    for (const Vector3d& p_O : places) question.presses.push_back(OnMembrane(p_O));
    if (places.empty()) question.presses = {UnderHome(scene, membrane->radius)};
  } else if (IsPlanar(scene.object.geometry)) {
    const Outline outline = OutlineOf(scene.object.geometry);
    if (outline.outer.empty()) {
      throw std::invalid_argument(
          "object.geometry.contour = from-image: in a study, expected an outline that needs no "
          "image");
    }
    std::vector<Vector3d> corners;
    for (const Vector2d& p : outline.outer) corners.emplace_back(p.x(), p.y(), 0);
    question.size = LargerSide(corners);
    question.presses = OnOutline(scene, outline, places);
  } else {
    const SurfaceMesh surface = SurfaceOf(MeshObject(scene, std::nullopt));
    question.size = LargerSide(surface.nodes);
    question.presses = OnVolume(scene, surface, places);
    const bool loaded = asked_places.empty() && !HasVolumeForce(scene) && !IsTouchedRound(scene);
    for (Press& press : question.presses) press.loaded = loaded;
  }
  question.width = scene.tool ? scene.tool->width : kToolPerSize * question.size;
  question.depth = scene.tool ? std::min(scene.operator_options.press_depth, 0.5 * question.size)
                              : kDefaultDepth * question.size;
  question.small_depth = small_depth > 0 ? std::min(small_depth, question.depth) : question.depth;
  // A flat punch on a half-space needs E w d / (1 - nu^2).
  question.load = scene.object.material.young_modulus * question.width * question.depth;
  return question;
}

std::vector<LoadPoint> RoundLoad(const SurfaceMesh& surface, const Vector3d& p_O,
                                 const Vector3d& inward_O, double width, bool quadratic) {
  std::vector<LoadPoint> points;
  double total = 0;
  for (int t = 0; t < static_cast<int>(surface.triangles.size()); ++t) {
    if (-Normal(surface, t).dot(inward_O) < kSameSide) continue;
    Matrix3d corners;
    for (int i = 0; i < 3; ++i) {
      const auto& nodes = surface.triangles[Index(t)];
      corners.col(i) = surface.nodes[Index(nodes[Index(i)])];
    }
    const Matrix3d m = Cut(corners, Area(surface, t), p_O, 0.5 * width).moment();
    const double area = m.sum();
    if (!(area > 0)) continue;
    total += area;
    const Vector3d first = m.rowwise().sum();
    if (!quadratic) points.push_back({corners * first / area, t, area});
    for (int i = 0; quadratic && i < 3; ++i) {
      const int j = (i + 1) % 3;
      points.push_back({corners.col(i), t, 2 * m(i, i) - first[i]});
      points.push_back({0.5 * (corners.col(i) + corners.col(j)), t, 4 * m(i, j)});
    }
  }
  for (LoadPoint& point : points) point.share /= total;
  return points;
}

}  // namespace palpate::study
