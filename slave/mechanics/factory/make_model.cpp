#include "slave/mechanics/factory/make_model.h"

#include <algorithm>
#include <array>
#include <optional>
#include <stdexcept>
#include <variant>
#include <vector>

#include "slave/mechanics/bem/bem2d_model.h"
#include "slave/mechanics/extruded/extruded_model.h"
#include "slave/mechanics/factory/choose_model.h"
#include "slave/mechanics/fem/fem_model.h"
#include "slave/mechanics/fem/green/fem_green_model.h"
#include "slave/mechanics/fem/solid/solid_model.h"
#include "slave/mechanics/plate/plate_large_model.h"
#include "slave/mechanics/plate/plate_model.h"
#include "slave/mechanics/relaxation/relaxing_model.h"
#include "slave/mesh/mesh_census.h"

namespace palpate {
namespace {

constexpr double kDefaultRange = 0.1;  // largest |displacement| / larger side

bool NeedsGeneralModel(const FemOptions& fem) {
  const bool moves = fem.time == FemOptions::Time::kDynamic;
  return fem.element == FemOptions::Element::kTet10 || fem.law == FemOptions::Law::kOgden ||
         (IsHyperelastic(fem.law) && moves);
}

// Uses the fast model for static four-node tetrahedra with a linear, co-rotational or neo-Hookean
// law, and the general model for ten-node elements and other laws.
std::unique_ptr<DeformationModel> MakeFem(const Scene& scene, const SolidMesh& mesh,
                                          Progress* progress) {
  const Material& material = scene.object.material;
  const FemOptions& options = scene.model.fem;
  const auto held = HeldTetNodes(scene, mesh);
  if (!NeedsGeneralModel(options)) {
    const double range = options.law == FemOptions::Law::kLinear ? scene.model.range : 0;
    return std::make_unique<FemModel>(
        mesh, held,
        FemModel::Params{.material = material,
                         .options = options,
                         .range = range,
                         .deadline = scene.model.deadline,
                         .contact = scene.model.contact,
                         .friction = scene.model.friction,
                         .tool = ShapesTool(scene) ? *scene.tool : Tool{}},
        progress);
  }
  const SolidModel::Params params{.options = options,
                                  .young_modulus = material.young_modulus,
                                  .poisson_ratio = material.poisson_ratio,
                                  .density = material.density,
                                  .range = scene.model.range,
                                  .limits = {}};
  return std::make_unique<SolidModel>(mesh, held, params, progress);
}

std::unique_ptr<DeformationModel> MakeFemGreen(const Scene& scene, const SolidMesh& mesh,
                                               Progress* progress) {
  const FemGreenModel::Options options{.element = scene.model.fem.element,
                                       .contact = scene.model.contact,
                                       .range = scene.model.range,
                                       .cache = scene.model.cache,
                                       .width = ContactWidth(scene)};
  const Material& material = scene.object.material;
  auto green =
      std::make_unique<FemGreenModel>(mesh, HeldTetNodes(scene, mesh), material.young_modulus,
                                      material.poisson_ratio, options, progress);
  if (material.relaxation.empty()) return green;
  return std::make_unique<RelaxingModel>(std::move(green), material.relaxation,
                                         scene.model.fem.step);
}

}  // namespace

namespace {

std::string KindName(const Scene& scene) {
  return scene.model.kind == "auto" ? ChooseModel(scene).model.kind : scene.model.kind;
}

}  // namespace

bool ShapesTool(const Scene& scene) {
  if (!scene.tool) return false;
  ModelOptions model = scene.model;
  model.kind = KindName(scene);
  return ShapesTool(model, *scene.tool);
}

const ModelKind& KindOf(const Scene& scene) {
  const std::string name = KindName(scene);
  const ModelKind* kind = FindModelKind(name);
  if (kind == nullptr) {
    throw std::invalid_argument("model.kind = " + name + ": expected a kind of model");
  }
  return *kind;
}

bool MovesInTime(const Scene& scene) {
  const ModelKind& kind = KindOf(scene);
  return (kind.iterates && scene.model.fem.time == FemOptions::Time::kDynamic) ||
         (kind.takes_relaxation && !scene.object.material.relaxation.empty());
}

bool IsLinear(const Scene& scene) {
  const Linearity linearity = KindOf(scene).linearity;
  return linearity == Linearity::kAlways ||
         (linearity == Linearity::kByLaw && scene.model.fem.law == FemOptions::Law::kLinear);
}

std::unique_ptr<Bem2dModel> MakePlanarModel(const Scene& scene, const BoundaryMesh& mesh,
                                            Progress* progress) {
  if (mesh.size() < 3) {
    throw std::invalid_argument("a mesh of " + std::to_string(mesh.size()) +
                                " elements: expected 3 or more");
  }
  const Bem2dModel::Params params{
      .young_modulus = scene.object.material.young_modulus,
      .thickness = ThicknessOf(scene.object.geometry),
      .contact = scene.model.contact,
      .range = scene.model.range > 0 ? scene.model.range : kDefaultRange};
  return std::make_unique<Bem2dModel>(
      ReferenceProblem{mesh, FixedElementDofs(scene, mesh), scene.object.material.poisson_ratio,
                       scene.model.plane, scene.model.order},
      params, progress);
}

bool AcceptsExtruded(const Scene& scene) {
  return IsPlanar(scene.object.geometry) && scene.tool && scene.tool->depth &&
         scene.tool->shape == Tool::Shape::kFlat && scene.model.contact == ContactLaw::kBonded &&
         scene.object.material.poisson_ratio <= kMaxExtrudedNu;
}

std::unique_ptr<ExtrudedModel> MakeExtrudedModel(const Scene& scene, const BoundaryMesh& mesh) {
  if (!scene.tool) throw std::invalid_argument("model.kind = extruded: expected a tool");
  const double T = ThicknessOf(scene.object.geometry);
  const double depth = std::min(scene.tool->depth.value_or(T), T);
  return std::make_unique<ExtrudedModel>(
      mesh, FixedElementDofs(scene, mesh),
      ExtrudedModel::Params{.young_modulus = scene.object.material.young_modulus,
                            .poisson_ratio = scene.object.material.poisson_ratio,
                            .thickness = T,
                            .front = scene.tool->BehindFront(T),
                            .depth = depth,
                            .range = scene.model.range > 0 ? scene.model.range : kDefaultRange});
}

std::unique_ptr<PlateSurface> MakePlateModel(const Scene& scene, const MembraneDisc& disc,
                                             Progress* progress) {
  const double E = scene.object.material.young_modulus, nu = scene.object.material.poisson_ratio;
  if (KindOf(scene).linearity == Linearity::kAlways) {
    return std::make_unique<PlateModel>(PlateModel::Params{disc.radius, disc.thickness, E, nu});
  }
  PlateLargeModel::Params params{disc.radius, disc.thickness, E, nu, scene.model.prestress};
  if (scene.model.modes > 0) params.order = scene.model.modes;
  return std::make_unique<PlateLargeModel>(params, progress);
}

std::unique_ptr<DeformationModel> MakeModel(const Scene& scene, const ObjectMesh& mesh,
                                            Progress* progress) {
  const ModelKind& kind = KindOf(scene);
  if (const auto* outline = std::get_if<BoundaryMesh>(&mesh)) {
    if (kind.is_plane) return MakePlanarModel(scene, *outline, progress);
    if (kind.object == ObjectClass::kOutline) return MakeExtrudedModel(scene, *outline);
  } else if (const auto* disc = std::get_if<MembraneDisc>(&mesh)) {
    if (kind.object == ObjectClass::kMembrane) return MakePlateModel(scene, *disc, progress);
  } else if (kind.object == ObjectClass::kVolume) {
    const auto& solid = std::get<SolidMesh>(mesh);
    return kind.iterates ? MakeFem(scene, solid, progress) : MakeFemGreen(scene, solid, progress);
  }
  throw std::invalid_argument("model.kind = " + std::string(kind.name) +
                              ": expected a model of this object");
}

HeldNodes HeldTetNodes(const Scene& scene, const SolidMesh& mesh) {
  auto held = FixedNodeDofs(scene, mesh.nodes);
  const std::vector<bool> used = UsedNodes(mesh.tets, mesh.nodes.size());
  for (std::size_t i = 0; i < used.size(); ++i) {
    if (!used[i]) held[i] = {true, true, true};
  }
  return held;
}

double ContactWidth(const Scene& scene) {
  const auto* tactile = scene.sense.Find<Tactile>();
  if (tactile != nullptr) return tactile->patch;
  return scene.tool ? scene.tool->width : 0;
}

}  // namespace palpate
