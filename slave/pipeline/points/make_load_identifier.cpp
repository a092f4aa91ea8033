#include <cmath>
#include <numbers>
#include <stdexcept>
#include <string>
#include <utility>
#include <variant>

#include <Eigen/Geometry>

#include "shared/mesh/disc_patch.h"
#include "slave/mechanics/factory/make_model.h"
#include "slave/pipeline/load/load_identifier.h"
#include "slave/pipeline/load/plate_load_identifier.h"
#include "slave/pipeline/press/membrane_body.h"

namespace palpate {
namespace {

using Eigen::Vector3d;

// Order of the modes, which resolves a tool of a tenth of the radius at a depth of 10 thicknesses
// [-]. [tuned: membrane_law_test]
constexpr int kFineModes = 20;

std::unique_ptr<PlateSurface> MakePlate(const Scene& scene, const MembraneGeometry& membrane,
                                        Progress* progress) {
  const ModelKind& kind = KindOf(scene);
  if (kind.object != ObjectClass::kMembrane) {
    throw std::invalid_argument("model.kind = " + std::string(kind.name) +
                                ": for a membrane in front of cameras, expected " +
                                KindsFor(ObjectClass::kMembrane));
  }
  if (!kind.takes_tension && scene.model.prestress > 0) {
    throw std::invalid_argument("model.prestress: only with kind: plate-large, which stretches");
  }
  return MakePlateModel(scene, {membrane.radius, membrane.thickness}, progress);
}

// Makes no finer plate if a study states the number of modes.
std::unique_ptr<PlateSurface> MakeFinerPlate(const Scene& scene, const MembraneGeometry& membrane,
                                             Progress* progress) {
  if (!KindOf(scene).takes_tension || scene.model.modes > 0) return nullptr;
  Scene finer = scene;
  finer.model.modes = kFineModes;
  return MakePlate(finer, membrane, progress);
}

// Difference of tension for the comparison of indentations [N/m]: half of the tension that matters
// to the plate, N0 + 16 D / a^2.
double OtherTension(const Scene& scene, const MembraneGeometry& membrane) {
  const double a = membrane.radius, t = membrane.thickness,
               nu = scene.object.material.poisson_ratio;
  const double D = scene.object.material.young_modulus * t * t * t / (12 * (1 - nu * nu));
  return 0.5 * (scene.model.prestress + 16 * D / (a * a));
}

std::unique_ptr<PlateSurface> MakeTighterPlate(const Scene& scene, const MembraneGeometry& membrane,
                                               Progress* progress) {
  if (!KindOf(scene).takes_tension) return nullptr;
  Scene tighter = scene;
  tighter.model.prestress += OtherTension(scene, membrane);
  return MakePlate(tighter, membrane, progress);
}

// Rings of positions on a disc [-].
constexpr int kRings = 3;

// Returns places that represent equal areas of a disc: the centre and rings of 6, 12, 18.
std::vector<Vector3d> PlacesOfDisc(const Vector3d& p, const Vector3d& n, double radius) {
  std::vector<Vector3d> places{p};
  if (!(radius > 0)) return places;
  const Vector3d along = n.unitOrthogonal(), across = n.cross(along);
  for (int ring = 1; ring <= kRings; ++ring) {
    const double r = radius * ring / (kRings + 0.5);
    for (int i = 0; i < 6 * ring; ++i) {
      const double angle = std::numbers::pi * i / (3 * ring);
      places.push_back(p + r * (std::cos(angle) * along + std::sin(angle) * across));
    }
  }
  return places;
}

}  // namespace

std::unique_ptr<LoadIdentifier> MakeLoadIdentifier(const Scene& scene, Progress* progress) {
  const double width = scene.tool ? scene.tool->width : 0;
  if (const auto* membrane = std::get_if<MembraneGeometry>(&scene.object.geometry)) {
    const bool is_rigid = scene.tool && scene.tool->IsRigidFace();
    return std::make_unique<PlateLoadIdentifier>(
        MakePlate(scene, *membrane, progress), PlateSurface::Tool{width, is_rigid},
        MakeFinerPlate(scene, *membrane, progress), MakeTighterPlate(scene, *membrane, progress),
        OtherTension(scene, *membrane), scene.model.prestress);
  }
  if (std::holds_alternative<DomeGeometry>(scene.object.geometry)) return MakeMembraneBody(scene);
  return MakeVolumeLoadIdentifier(scene, width, progress);
}

void SpreadLoad(const SurfaceMesh& surface, const Vector3d& p_O, const Vector3d& n_O, double width,
                const Vector3d& force_O, std::vector<Vector3d>* f_O) {
  f_O->assign(surface.nodes.size(), Vector3d::Zero());
  std::vector<SurfacePlace> met;
  for (const Vector3d& p : PlacesOfDisc(p_O, n_O, width / 2)) {
    const auto place = FindPlace(surface, p);
    if (place && place->triangle >= 0) met.push_back(*place);
  }
  for (const SurfacePlace& place : met) {
    const auto& nodes = surface.triangles[static_cast<std::size_t>(place.triangle)];
    for (std::size_t c = 0; c < 3; ++c) {
      (*f_O)[static_cast<std::size_t>(nodes[c])] +=
          place.weights[static_cast<Eigen::Index>(c)] / static_cast<double>(met.size()) * force_O;
    }
  }
}

}  // namespace palpate
