#include "slave/site/fingertip/true_object.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <stdexcept>
#include <string>
#include <variant>

#include "slave/mechanics/object_mesh.h"
#include "slave/site/fingertip/surface_rays.h"

namespace palpate::site {
namespace {

using Eigen::Isometry3d;
using Eigen::Vector3d;

constexpr double kTouching = 1e-3;  // radii that a fingertip at home may be inside by rounding

[[noreturn]] void Refuse(const std::string& what) {
  throw std::invalid_argument(what);
}

const Tactile& CheckedTactile(const Scene& scene) {
  if (!scene.sense.tactile) {
    Refuse("sense.tactile: missing; a simulated site with fingertips needs it");
  }
  const Tactile& tactile = *scene.sense.tactile;
  if (tactile.fingers.empty() || tactile.fingers.size() > kMaxFingers) {
    Refuse("sense.tactile.fingers = " + std::to_string(tactile.fingers.size()) +
           ": accepted are 1 to 5");
  }
  if (tactile.fingers.front().motion != Finger::Motion::kHand) {
    Refuse("sense.tactile.fingers." + tactile.fingers.front().name +
           ".motion: accepted for the first finger is hand");
  }
  if (!(tactile.rate > 0 && std::isfinite(tactile.rate))) {
    Refuse("sense.tactile.rate = " + std::to_string(tactile.rate) + ": accepted is > 0");
  }
  if (!(tactile.finger_radius > 0 && std::isfinite(tactile.finger_radius))) {
    Refuse("sense.tactile.radius = " + std::to_string(tactile.finger_radius) + ": accepted is > 0");
  }
  for (const Finger& finger : tactile.fingers) {
    if (finger.X_SF.matrix().allFinite()) continue;
    Refuse("sense.tactile.fingers." + finger.name + ".pose: accepted is a finite pose");
  }
  return tactile;
}

void CheckObject(const Object& object) {
  if (!IsVolume(object.geometry)) {
    Refuse("object.geometry: accepted by a site with fingertips is a volume: box or mesh");
  }
  if (object.fixed.empty()) {
    Refuse("object.fixed: missing; a site with fingertips holds the object somewhere");
  }
  for (const Fixed& fixed : object.fixed) {
    if (!std::holds_alternative<FixedNodes>(fixed.where)) continue;
    Refuse(
        "object.fixed.nodes: accepted by a site with fingertips is a plane; its mesh is another");
  }
}

// The surface before it is refined.
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

// What lies ahead of `p_O`; towards the middle of the object if nothing does.
RayHit Ahead(const SurfaceMesh& surface, const Vector3d& p_O, const Vector3d& direction_O,
             Vector3d* place_O) {
  Vector3d d = direction_O;
  auto hit = FirstHit(surface, p_O, d);
  if (!hit) {
    d = (CentreOf(surface) - p_O).normalized();
    hit = FirstHit(surface, p_O, d);
  }
  if (!hit) Refuse("sense.tactile: the object lies nowhere ahead of a fingertip");
  *place_O = p_O + hit->distance * d;
  return *hit;
}

// Where each finger will touch.
std::vector<Vector3d> Focuses(const SurfaceMesh& surface, const FingerHand& hand) {
  std::vector<Vector3d> focuses;
  for (const auto& finger : hand.fingers) {
    const Vector3d pad_O = finger.X_OF_home.linear() * Vector3d(0, 0, -1);
    const Vector3d way_O = finger.sense != 0 ? Vector3d(finger.sense * hand.approach_O) : pad_O;
    Vector3d place_O;
    Ahead(surface, finger.X_OF_home.translation(), way_O, &place_O);
    focuses.push_back(place_O);
  }
  return focuses;
}

bool Overlaps(const SurfaceMesh& surface, const RigidFinger& finger, const Isometry3d& X_OF) {
  const Isometry3d X_FO = X_OF.inverse();
  const auto is_in_finger = [&](const Vector3d& p_O) {
    return finger.Distance(X_FO * p_O) < -kTouching * finger.radius;
  };
  if (std::ranges::any_of(surface.nodes, is_in_finger)) return true;
  // A finger in the middle of a large face, or of the object, has no node in it.
  const double r = (1 - kTouching) * finger.radius;
  for (const double x : {0.0, -0.25, -0.5, -0.75, -1.0}) {
    const Vector3d axis(x * finger.length, 0, 0);
    for (const Vector3d& out :
         {Vector3d(0, 0, 0), Vector3d(r, 0, 0), Vector3d(-r, 0, 0), Vector3d(0, r, 0),
          Vector3d(0, -r, 0), Vector3d(0, 0, r), Vector3d(0, 0, -r)}) {
      const Vector3d p_F = axis + out;
      if (finger.Distance(p_F) < 0 && IsInside(surface, X_OF * p_F)) return true;
    }
  }
  return false;
}

void CheckHome(const Tactile& tactile, const SurfaceMesh& surface, const FingerHand& hand) {
  for (std::size_t f = 0; f < hand.fingers.size(); ++f) {
    if (!Overlaps(surface, hand.shape, hand.fingers[f].X_OF_home)) continue;
    const std::string& name = tactile.fingers[f].name;
    Refuse("sense.tactile.fingers" + (name.empty() ? std::string() : "." + name) +
           ".pose: the fingertip is inside the object; accepted is a pose outside it");
  }
}

// Keeps the nodes that triangles use.
void Compact(TrueObject* object) {
  std::vector<int> number(object->surface.nodes.size(), -1);
  std::vector<Vector3d> nodes;
  for (auto& triangle : object->surface.triangles) {
    for (int& node : triangle) {
      int& known = number[static_cast<std::size_t>(node)];
      if (known < 0) {
        known = static_cast<int>(nodes.size());
        nodes.push_back(object->surface.nodes[static_cast<std::size_t>(node)]);
        object->node_of.push_back(node);
      }
      node = known;
    }
  }
  object->surface.nodes = std::move(nodes);
}

}  // namespace

TrueObject MakeTrueObject(const Scene& scene, const SiteResolution& resolution) {
  const Tactile& tactile = CheckedTactile(scene);
  CheckObject(scene.object);
  TrueObject object;
  object.X_SO = scene.object.X_SO;
  object.X_SO.translation().head<2>() += scene.site.misplacement;
  object.hand = MakeFingerHand(tactile, object.X_SO);

  const SurfaceMesh plain = PlainSurface(scene.object.geometry);
  CheckHome(tactile, plain, object.hand);
  const Isometry3d& X_OF = object.hand.fingers.front().X_OF_home;
  Vector3d place_O;
  object.hand.approach_O =
      -Ahead(plain, X_OF.translation(), X_OF.linear() * Vector3d(0, 0, -1), &place_O).n_O;

  BodyAtRest& body = object.body;
  body.mesh = MeshForFingers(scene.object.geometry, Focuses(plain, object.hand), resolution);
  body.held = HeldNodes(scene, body.mesh.nodes);
  body.young_modulus = scene.object.material.young_modulus;
  body.poisson_ratio = scene.object.material.poisson_ratio;
  object.surface = SurfaceOf(body.mesh);
  Compact(&object);
  for (std::size_t i = 0; i < object.node_of.size(); ++i) {
    if (body.held[static_cast<std::size_t>(object.node_of[i])][0]) continue;
    body.touchable_O.push_back(object.surface.nodes[i]);
  }
  return object;
}

}  // namespace palpate::site
