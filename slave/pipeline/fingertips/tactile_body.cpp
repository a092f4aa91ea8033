#include "slave/pipeline/fingertips/tactile_body.h"

#include <algorithm>
#include <stdexcept>
#include <utility>
#include <variant>

#include "shared/geometry/index.h"
#include "slave/mechanics/make_model.h"

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

}  // namespace

Scene InStepWithSamples(const Scene& scene) {
  Scene stepped = scene;
  stepped.model.fem.step = 1 / scene.sense.Find<Tactile>()->rate;
  return stepped;
}

std::unique_ptr<TactileBody> MakeTactileBody(const Scene& scene, Progress* progress) {
  const Scene stepped = InStepWithSamples(scene);
  const ObjectMesh mesh = MeshObject(stepped, std::nullopt);
  const auto* solid = std::get_if<SolidMesh>(&mesh);
  const auto* closed = std::get_if<SurfaceMesh>(&mesh);
  if (solid == nullptr && closed == nullptr) {
    throw std::invalid_argument(
        "object.geometry: accepted under fingertips with a pose is a volume: box or mesh");
  }
  auto body = std::make_unique<TactileBody>();
  body->surface = solid != nullptr ? SurfaceOf(*solid) : *closed;
  body->deformation = MakeModel(stepped, mesh, body->limit.Listen(progress));
  body->contact = std::make_unique<SurfaceContact>(body->surface);
  body->stiffness = std::make_unique<ContactStiffness>(stepped, body->surface, solid);
  NumberSkin(stepped, body.get());
  body->larger_side = LargerSide(body->surface.nodes);
  body->largest_force = scene.object.material.young_modulus * body->larger_side * body->larger_side;
  body->limit.Finish();
  body->moves_in_time = MovesInTime(stepped);
  return body;
}

}  // namespace palpate
