#include <stdexcept>
#include <string>
#include <utility>
#include <variant>

#include "slave/mechanics/make_model.h"
#include "slave/pipeline/load/load_identifier.h"
#include "slave/pipeline/load/plate_load_identifier.h"
#include "slave/pipeline/load/volume_load_identifier.h"

namespace palpate {
namespace {

constexpr int kFineModes = 20;  // order: resolves a tool of a tenth of the radius 10 t deep

std::unique_ptr<PlateSurface> MakePlate(const Scene& scene, const MembraneGeometry& membrane) {
  const ModelKind& kind = KindOf(scene);
  if (kind.object != ObjectClass::kMembrane) {
    throw std::invalid_argument("model.kind = " + std::string(kind.name) +
                                ": accepted for a membrane under the eyes is " +
                                KindsFor(ObjectClass::kMembrane));
  }
  if (!kind.takes_tension && scene.model.prestress > 0) {
    throw std::invalid_argument(
        "model.prestress: accepted with kind: plate-large, which stretches");
  }
  return MakePlateModel(scene, {membrane.radius, membrane.thickness});
}

// Where the scene leaves the modes to the model.
std::unique_ptr<PlateSurface> MakeFinerPlate(const Scene& scene, const MembraneGeometry& membrane) {
  if (!KindOf(scene).takes_tension || scene.model.modes > 0) return nullptr;
  Scene finer = scene;
  finer.model.modes = kFineModes;
  return MakePlate(finer, membrane);
}

}  // namespace

std::unique_ptr<LoadIdentifier> MakeLoadIdentifier(const Scene& scene) {
  const double width = scene.tool ? scene.tool->width : 0;
  if (const auto* membrane = std::get_if<MembraneGeometry>(&scene.object.geometry)) {
    return std::make_unique<PlateLoadIdentifier>(MakePlate(scene, *membrane), width,
                                                 MakeFinerPlate(scene, *membrane));
  }
  return MakeVolumeLoadIdentifier(scene, width);
}

}  // namespace palpate
