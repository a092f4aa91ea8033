#include "slave/pipeline/fingertips/tactile_body.h"

#include <algorithm>
#include <cmath>
#include <exception>
#include <limits>
#include <optional>
#include <stdexcept>
#include <utility>
#include <variant>

#include "slave/mechanics/factory/make_model.h"
#include "slave/mesh/index.h"

namespace palpate {
namespace {

void NumberSkin(const Scene& scene, TactileBody* body) {
  std::vector<int> number(body->surface.nodes.size(), -1);
  for (const auto& triangle : body->surface.triangles) {
    for (const int node : triangle) {
      int& known = number[Index(node)];
      if (known < 0) {
        known = static_cast<int>(body->skin.size());
        body->skin.push_back(node);
      }
      body->skin_triangles.push_back(static_cast<std::uint32_t>(known));
    }
  }
  for (const std::uint32_t node : HeldVertices(scene, body->surface)) {
    if (number[node] >= 0) body->skin_held.push_back(static_cast<std::uint32_t>(number[node]));
  }
}

// Returns the surface point nearest to a finger at home.
std::optional<TouchedPlace> PlaceOf(const Scene& scene, const SurfaceContact& contact,
                                    const Finger& finger) {
  return contact.Find(scene.object.X_SO.inverse() * finger.X_SF.translation(),
                      std::numeric_limits<double>::infinity());
}

// Returns the expected contacts of fingers that have a pose.
std::vector<Contact> FirstContacts(const Scene& scene, const SurfaceContact& contact) {
  const Tactile& tactile = *scene.sense.Find<Tactile>();
  std::vector<Contact> contacts;
  for (const Finger& finger : tactile.fingers) {
    const auto place = finger.has_pose ? PlaceOf(scene, contact, finger) : std::nullopt;
    if (!place) continue;
    contacts.push_back({.p_O = place->p_O, .element = place->triangle, .width = tactile.patch});
  }
  return contacts;
}

// Returns the other fingers that will press at about the same time as the first one: those that are
// equally far from the object at home. Without poses there are none.
std::vector<ContactStiffness::Companion> CompanionsOf(const Scene& scene,
                                                      const SurfaceContact& contact) {
  constexpr double kAsFar = 0.5;  // of the full depth
  const Tactile& tactile = *scene.sense.Find<Tactile>();
  const double depth = scene.operator_options.press_depth;
  std::vector<ContactStiffness::Companion> companions;
  if (tactile.fingers.empty() || !tactile.fingers.front().has_pose) return companions;
  const auto first = PlaceOf(scene, contact, tactile.fingers.front());
  for (std::size_t i = 1; first && i < tactile.fingers.size(); ++i) {
    const Finger& finger = tactile.fingers[i];
    if (!finger.has_pose || finger.motion == Finger::Motion::kAtRest) continue;
    const auto place = PlaceOf(scene, contact, finger);
    if (!place || std::abs(place->distance - first->distance) > kAsFar * depth) continue;
    companions.push_back(
        {place->triangle, place->p_O, finger.motion == Finger::Motion::kOpposite ? -1.0 : 1.0});
  }
  return companions;
}

// Computes the stiffness that the local model of the first finger needs at and beside its next
// contact.
void PrefetchStiffness(const Scene& scene, TactileBody* body) {
  const Tactile& tactile = *scene.sense.Find<Tactile>();
  if (tactile.fingers.empty() || !tactile.fingers.front().has_pose) return;
  const auto place = PlaceOf(scene, *body->contact, tactile.fingers.front());
  if (!place) return;
  for (std::size_t t = 0; t < body->surface.triangles.size(); ++t) {
    const auto is_near = [&](int node) {
      return (body->surface.nodes[Index(node)] - place->p_O).norm() <= tactile.patch / 2;
    };
    const int triangle = static_cast<int>(t);
    if (triangle != place->triangle && !std::ranges::any_of(body->surface.triangles[t], is_near)) {
      continue;
    }
    (void)body->stiffness->At(triangle, Eigen::Vector3d::Constant(1.0 / 3), tactile.finger_radius);
  }
}

}  // namespace

Scene InStepWithSamples(const Scene& scene) {
  Scene stepped = scene;
  stepped.model.fem.step = 1 / scene.sense.Find<Tactile>()->rate;
  return stepped;
}

std::unique_ptr<TactileBody> MakeTactileBody(const Scene& scene, Progress* progress) {
  Scene stepped = InStepWithSamples(scene);
  stepped.tool.reset();  // the tool belongs to `solve` and `study`; here fingertips touch
  const ObjectMesh mesh = MeshObject(stepped, std::nullopt);
  const auto* solid = std::get_if<SolidMesh>(&mesh);
  if (solid == nullptr) {
    throw std::invalid_argument(
        "object.geometry: under fingertips with a pose, expected a volume: box or mesh");
  }
  auto body = std::make_unique<TactileBody>();
  body->surface = SurfaceOf(*solid);
  body->deformation = MakeModel(stepped, mesh, body->limit.Listen(progress));
  body->contact = std::make_unique<SurfaceContact>(body->surface);
  body->stiffness = std::make_unique<ContactStiffness>(stepped, body->surface, solid,
                                                       CompanionsOf(stepped, *body->contact));
  try {
    body->deformation->Prefetch(FirstContacts(stepped, *body->contact));
    PrefetchStiffness(stepped, body.get());
    // The same failure is reported, with its reason, at the first contact.
  } catch (const std::exception&) {
  }
  NumberSkin(stepped, body.get());
  body->larger_side = LargerSide(body->surface.nodes);
  body->largest_force = scene.object.material.young_modulus * body->larger_side * body->larger_side;
  body->limit.Finish();
  body->moves_in_time = MovesInTime(stepped);
  body->has_friction = stepped.model.contact == ContactLaw::kFriction && ContactWidth(stepped) > 0;
  return body;
}

}  // namespace palpate
