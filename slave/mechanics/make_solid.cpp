#include "slave/mechanics/make_solid.h"

#include <array>
#include <vector>

#include "slave/mechanics/bem3d/bem3d_model.h"
#include "slave/mechanics/fem/fem_model.h"
#include "slave/mechanics/fem/green/fem_green_model.h"
#include "slave/mechanics/fem/solid/solid_model.h"

namespace palpate {
namespace {

std::vector<std::array<bool, 3>> HeldTriangles(const SurfaceMesh& mesh,
                                               const std::vector<std::array<bool, 3>>& nodes) {
  std::vector<std::array<bool, 3>> held;
  held.reserve(mesh.triangles.size());
  for (const auto& triangle : mesh.triangles) {
    std::array<bool, 3> all{true, true, true};
    for (const int node : triangle) {
      for (std::size_t c = 0; c < 3; ++c) {
        all[c] = all[c] && nodes[static_cast<std::size_t>(node)][c];
      }
    }
    held.push_back(all);
  }
  return held;
}

// What the scene holds, and nodes that belong to no element: they have no stiffness of their own.
std::vector<std::array<bool, 3>> HeldNodesOf(const Scene& scene, const SolidMesh& mesh) {
  auto held = FixedNodeDofs(scene, mesh.nodes);
  std::vector<char> used(mesh.nodes.size(), 0);
  for (const auto& tet : mesh.tets) {
    for (const int node : tet) used[static_cast<std::size_t>(node)] = 1;
  }
  for (std::size_t i = 0; i < used.size(); ++i) {
    if (used[i] == 0) held[i] = {true, true, true};
  }
  return held;
}

bool NeedsGeneralModel(const FemOptions& fem) {
  const bool has_own_pressure = fem.pressure == FemOptions::Pressure::kAveraged ||
                                fem.pressure == FemOptions::Pressure::kMixed;
  return fem.element == FemOptions::Element::kTet10 || fem.law == FemOptions::Law::kNeoHookean ||
         has_own_pressure;
}

}  // namespace

std::unique_ptr<DeformationModel> MakeFem(const Scene& scene, const SolidMesh& mesh,
                                          Progress* progress) {
  const Material& material = scene.object.material;
  const auto held = HeldNodesOf(scene, mesh);
  if (!NeedsGeneralModel(scene.model.fem)) {
    FemModel::Params params;
    params.material = material;
    params.options = scene.model.fem;
    const bool is_linear = scene.model.fem.law == FemOptions::Law::kLinear;
    params.range = is_linear ? scene.model.range : 0;
    return std::make_unique<FemModel>(mesh, held, params, progress);
  }
  SolidModel::Params params;
  params.options = scene.model.fem;
  params.young_modulus = material.young_modulus;
  params.poisson_ratio = material.poisson_ratio;
  params.density = material.density;
  params.range = scene.model.range;
  return std::make_unique<SolidModel>(mesh, held, params, progress);
}

std::unique_ptr<DeformationModel> MakeFemGreen(const Scene& scene, const SolidMesh& mesh,
                                               Progress* progress) {
  FemGreenModel::Options options;
  options.element = scene.model.fem.element == FemOptions::Element::kTet10 ? TetElement::kTet10
                                                                           : TetElement::kTet4;
  options.contact = scene.model.contact;
  options.range = scene.model.range;
  options.cache = scene.model.cache;
  const Material& material = scene.object.material;
  return std::make_unique<FemGreenModel>(mesh, HeldNodesOf(scene, mesh), material.young_modulus,
                                         material.poisson_ratio, options, progress);
}

std::unique_ptr<DeformationModel> MakeBem3d(const Scene& scene, const SurfaceMesh& mesh,
                                            Progress* progress) {
  Bem3dModel::Options options;
  options.contact = scene.model.contact;
  options.range = scene.model.range;
  options.cache = scene.model.cache;
  const Material& material = scene.object.material;
  return std::make_unique<Bem3dModel>(mesh, HeldTriangles(mesh, FixedNodeDofs(scene, mesh.nodes)),
                                      material.young_modulus, material.poisson_ratio, options,
                                      progress);
}

}  // namespace palpate
