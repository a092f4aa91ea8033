#include "slave/mechanics/make_model.h"

#include <stdexcept>
#include <utility>
#include <variant>

#include "slave/mechanics/bem/bem2d_model.h"

namespace palpate {
namespace {

constexpr double kDefaultRange = 0.1;  // largest |displacement| / larger side

std::unique_ptr<DeformationModel> MakeBem2d(const Scene& scene, const BoundaryMesh& mesh) {
  if (mesh.size() < 3) {
    throw std::invalid_argument("a mesh of " + std::to_string(mesh.size()) +
                                " elements: accepted is 3 or more");
  }
  Bem2dModel::Params params;
  params.young_modulus = scene.object.material.young_modulus;
  params.thickness = ThicknessOf(scene.object.geometry);
  params.contact = scene.model.contact;
  params.range = scene.model.range > 0 ? scene.model.range : kDefaultRange;
  return std::make_unique<Bem2dModel>(
      ReferenceProblem{mesh, HeldElements(scene, mesh), scene.object.material.poisson_ratio,
                       scene.model.plane},
      params);
}
}  // namespace

ModelChoice ChooseModel(const Scene& scene) {
  if (scene.model.kind != "auto") return {scene.model.kind, "asked for by model.kind"};
  const Geometry& geometry = scene.object.geometry;
  if (std::holds_alternative<MembraneGeometry>(geometry)) {
    return {"plate",
            "membrane: the clamped plate's closed form; no study of this scene exists yet"};
  }
  if (IsVolume(geometry)) {
    return {"fem", "volume: co-rotational finite elements; no study of this scene exists yet"};
  }
  return {"bem2d",
          "planar outline: two-dimensional boundary elements; no study of this scene exists yet"};
}

bool MovesInTime(const Scene& scene) {
  const std::string kind = ChooseModel(scene).kind;
  return (kind == "fem" || kind == "fem-hyperelastic") &&
         scene.model.fem.time == FemOptions::Time::kDynamic;
}

std::unique_ptr<DeformationModel> MakeModel(const Scene& scene, const ObjectMesh& mesh,
                                            Progress* /*progress*/) {
  const ModelChoice choice = ChooseModel(scene);
  if (choice.kind == "bem2d" && std::holds_alternative<BoundaryMesh>(mesh)) {
    return MakeBem2d(scene, std::get<BoundaryMesh>(mesh));
  }
  throw std::invalid_argument("model.kind = " + choice.kind + ": accepted is auto or bem2d");
}

}  // namespace palpate
