#include "slave/simulator/fingertips/true_object.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <cstddef>
#include <stdexcept>
#include <string>
#include <utility>
#include <variant>

#include <Eigen/Geometry>
#include <spdlog/fmt/fmt.h>

#include "shared/state/slave_state.h"
#include "slave/contact/surface_contact.h"
#include "slave/mechanics/object_mesh.h"
#include "slave/mesh/index.h"

namespace palpate::simulation {
namespace {

using Eigen::Isometry3d;
using Eigen::Vector3d;

// Moeller and Trumbore's test (1997).
std::optional<double> Crossing(const std::array<Vector3d, 3>& abc, const Vector3d& p,
                               const Vector3d& d) {
  const Vector3d ab = abc[1] - abc[0], ac = abc[2] - abc[0];
  const Vector3d across = d.cross(ac);
  const double determinant = ab.dot(across);
  if (determinant == 0) return std::nullopt;
  const Vector3d ap = p - abc[0];
  const double u = ap.dot(across) / determinant;
  const Vector3d turned = ap.cross(ab);
  const double v = d.dot(turned) / determinant;
  const double t = ac.dot(turned) / determinant;
  if (!(u >= 0 && v >= 0 && u + v <= 1 && t > 0)) return std::nullopt;
  return t;
}

std::array<Vector3d, 3> CornersOf(const SurfaceMesh& surface, const std::array<int, 3>& triangle) {
  std::array<Vector3d, 3> abc;
  for (std::size_t i = 0; i < 3; ++i) {
    abc[i] = surface.nodes[Index(triangle[i])];
  }
  return abc;
}

constexpr double kTouching = 1e-3;  // radii that a fingertip at home may be inside by rounding

[[noreturn]] void Refuse(const std::string& what) {
  throw std::invalid_argument(what);
}

void CheckObject(const Object& object) {
  if (!IsVolume(object.geometry)) {
    Refuse("object.geometry: the simulator of fingertips expects a volume: box or mesh");
  }
  if (object.fixed.empty()) {
    Refuse("object.fixed: missing; the simulator of fingertips needs a fixed part");
  }
  for (const Fixed& fixed : object.fixed) {
    if (!std::holds_alternative<FixedNodes>(fixed.where)) continue;
    Refuse(
        "object.fixed.nodes: the simulator of fingertips expects a plane, because its mesh "
        "differs");
  }
  const double nu = object.material.poisson_ratio;
  if (!(nu < TrueObject::kMaxPoisson)) {
    Refuse(
        fmt::format("object.material.poisson_ratio = {:g}: the simulator of fingertips "
                    "expects -1 < nu < {:g}",
                    nu, TrueObject::kMaxPoisson));
  }
}

// Returns the surface before refinement.
SurfaceMesh PlainSurface(const Geometry& geometry) {
  if (const auto* box = std::get_if<BoxGeometry>(&geometry)) {
    return SurfaceOf(MeshBox(box->size, {1, 1, 1}));
  }
  return SurfaceOf(OwnMesh(geometry));
}

Vector3d CentreOf(const SurfaceMesh& surface) {
  Eigen::Array3d low = surface.nodes.front(), high = low;
  for (const auto& p : surface.nodes) low = low.min(p.array()), high = high.max(p.array());
  return 0.5 * (low + high);
}

Eigen::AlignedBox3d BoundsOf(const Region& region) {
  const auto* ball = std::get_if<Ball>(&region.where);
  if (ball == nullptr) return std::get<Eigen::AlignedBox3d>(region.where);
  const Vector3d reach = Vector3d::Constant(ball->radius);
  return {ball->centre - reach, ball->centre + reach};
}

// Returns the hit on the surface ahead of `p_O`, or if there is none, towards the centre of the
// object.
RayHit Ahead(const SurfaceMesh& surface, const Vector3d& p_O, const Vector3d& direction_O,
             Vector3d* place_O) {
  Vector3d d = direction_O;
  auto hit = FirstHit(surface, p_O, d);
  if (!hit) {
    d = (CentreOf(surface) - p_O).normalized();
    hit = FirstHit(surface, p_O, d);
  }
  if (!hit) Refuse("sense.tactile: the object is not in front of a fingertip");
  *place_O = p_O + hit->distance * d;
  return *hit;
}

bool Overlaps(const SurfaceContact& surface, const RigidFinger& finger, const Isometry3d& X_OF) {
  constexpr int kPlaces = 16;  // along the axis
  for (int i = 0; i <= kPlaces; ++i) {
    const Vector3d p_O = X_OF * Vector3d(-finger.length * i / kPlaces, 0, 0);
    const auto place = surface.Find(p_O, (1 - kTouching) * finger.radius);
    if (place || IsInside(surface.surface(), p_O)) return true;
  }
  return false;
}

// Keeps the nodes that triangles use.
void Compact(RestBody* body) {
  std::vector<int> number(body->surface.nodes.size(), -1);
  std::vector<Vector3d> nodes;
  for (auto& triangle : body->surface.triangles) {
    for (int& node : triangle) {
      int& known = number[Index(node)];
      if (known < 0) {
        known = static_cast<int>(nodes.size());
        nodes.push_back(body->surface.nodes[Index(node)]);
        body->node_of.push_back(node);
      }
      node = known;
    }
  }
  body->surface.nodes = std::move(nodes);
}

}  // namespace

std::optional<RayHit> FirstHit(const SurfaceMesh& surface, const Vector3d& p_O,
                               const Vector3d& direction_O) {
  std::optional<RayHit> first;
  for (const auto& triangle : surface.triangles) {
    const auto abc = CornersOf(surface, triangle);
    const auto t = Crossing(abc, p_O, direction_O);
    if (!t || (first && *t >= first->distance)) continue;
    first = {*t, (abc[1] - abc[0]).cross(abc[2] - abc[0]).normalized()};
  }
  return first;
}

bool IsInside(const SurfaceMesh& surface, const Vector3d& p_O) {
  const Vector3d d = Vector3d(0.5377, 0.7139, 0.4483).normalized();  // along no edge of a box
  bool inside = false;
  for (const auto& triangle : surface.triangles) {
    if (Crossing(CornersOf(surface, triangle), p_O, d)) inside = !inside;
  }
  return inside;
}

TrueObject::TrueObject(const Scene& scene, const SiteResolution& resolution)
    : scene_(scene),
      resolution_(resolution),
      X_SO_(TruePose(scene)),
      hand_((CheckObject(scene.object), MakeFingerHand(*scene.sense.Find<Tactile>(), X_SO_))),
      plain_(PlainSurface(scene.object.geometry)) {
  CheckHome();
  const Isometry3d& X_OF = hand_.fingers.front().X_OF_home;
  Vector3d place_O;
  hand_.approach_O =
      -Ahead(plain_, X_OF.translation(), X_OF.linear() * Vector3d(0, 0, -1), &place_O).n_O;
  if (const auto* box = std::get_if<BoxGeometry>(&scene.object.geometry)) {
    CountHexahedra(*box);
  } else {
    file_body_ = Finish(MeshTetrahedra(OwnMesh(scene.object.geometry), resolution.max_tets));
  }
}

void TrueObject::CountHexahedra(const BoxGeometry& box) {
  constexpr double kCoarser = 1.1;
  for (;;) {
    const auto axes = GradedAxes(box, Vector3d::Zero());
    std::array<int, 3> count{};
    for (std::size_t a = 0; a < 3; ++a) count[a] = static_cast<int>(axes[a].size()) - 1;
    const bool is_coarsest = resolution_.edge > box.size.maxCoeff();
    if (is_coarsest || count[0] * count[1] * count[2] <= resolution_.max_hexahedra) {
      hexahedra_ = count;
      return;
    }
    resolution_.edge *= kCoarser;
    resolution_.growth *= kCoarser;
  }
}

void TrueObject::CheckHome() const {
  const SurfaceContact surface(plain_);
  for (std::size_t f = 0; f < hand_.fingers.size(); ++f) {
    if (!Overlaps(surface, hand_.shape, hand_.fingers[f].X_OF_home)) continue;
    const std::string& name = scene_.sense.Find<Tactile>()->fingers[f].name;
    Refuse("sense.tactile.fingers." + name +
           ".pose: the fingertip is inside the object; expected a pose outside it");
  }
}

// Returns the expected contact position of each finger.
std::vector<Vector3d> TrueObject::Focuses(const Vector3d& lateral_O) const {
  std::vector<Vector3d> focuses;
  for (std::size_t f = 0; f < hand_.fingers.size(); ++f) {
    const Isometry3d X_OF = hand_.PoseOf(f, lateral_O);
    const double sense = hand_.fingers[f].sense;
    const Vector3d pad_O = X_OF.linear() * Vector3d(0, 0, -1);
    Vector3d place_O;
    Ahead(plain_, X_OF.translation(), sense != 0 ? Vector3d(sense * hand_.approach_O) : pad_O,
          &place_O);
    focuses.push_back(place_O);
  }
  return focuses;
}

std::array<std::vector<double>, 3> TrueObject::GradedAxes(const BoxGeometry& box,
                                                          const Vector3d& lateral_O) const {
  std::array<AxisGrading, 3> wishes;
  for (int a = 0; a < 3; ++a) wishes[Index(a)].length = box.size[a];
  for (const Vector3d& p_O : Focuses(lateral_O)) {
    for (int a = 0; a < 3; ++a) wishes[Index(a)].focuses.push_back(p_O[a]);
  }
  for (const Fixed& fixed : scene_.object.fixed) {
    const auto* plane = std::get_if<FixedPlane>(&fixed.where);
    if (plane) wishes[Index(plane->axis)].others.push_back(plane->at);
  }
  for (const Region& region : scene_.object.regions) {
    const Eigen::AlignedBox3d bounds = BoundsOf(region);
    for (int a = 0; a < 3; ++a) {
      for (const double end : {bounds.min()[a], bounds.max()[a]}) {
        if (end > 0 && end < box.size[a]) wishes[Index(a)].others.push_back(end);
      }
    }
  }
  std::array<std::vector<double>, 3> axes;
  for (std::size_t a = 0; a < 3; ++a) axes[a] = GradedAxis(wishes[a], resolution_, hexahedra_[a]);
  return axes;
}

std::shared_ptr<const RestBody> TrueObject::BodyFor(const Vector3d& lateral_O) const {
  const auto* box = std::get_if<BoxGeometry>(&scene_.object.geometry);
  return box ? Finish(MeshGradedBox(GradedAxes(*box, lateral_O))) : file_body_;
}

std::shared_ptr<const RestBody> TrueObject::Finish(SiteMesh mesh) const {
  auto body = std::make_shared<RestBody>();
  body->mesh = std::move(mesh);
  body->held = FixedNodeDofs(scene_, body->mesh.nodes);
  body->surface = {body->mesh.nodes, body->mesh.triangles};
  Compact(body.get());
  for (std::size_t i = 0; i < body->node_of.size(); ++i) {
    if (body->held[Index(body->node_of[i])][0]) continue;
    body->touchable_O.push_back(body->surface.nodes[i]);
  }
  return body;
}

}  // namespace palpate::simulation
