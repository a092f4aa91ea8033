#include <stdexcept>
#include <variant>

#include "slave/mechanics/make_model.h"
#include "slave/mechanics/plate/plate_large_model.h"
#include "slave/mechanics/plate/plate_model.h"
#include "slave/pipeline/plate_body.h"
#include "slave/pipeline/surface_estimator.h"
#include "slave/pipeline/volume_body.h"

namespace palpate {
namespace {

std::unique_ptr<PlateSurface> MakePlate(const Scene& scene, const MembraneGeometry& membrane,
                                        const std::string& kind) {
  const Material& material = scene.object.material;
  if (kind == "plate") {
    if (scene.model.prestress > 0) {
      throw std::invalid_argument(
          "model.prestress: accepted with kind: plate-large, which stretches");
    }
    return std::make_unique<PlateModel>(
        PlateModel::Params{.radius = membrane.radius,
                           .thickness = membrane.thickness,
                           .young_modulus = material.young_modulus,
                           .poisson_ratio = material.poisson_ratio});
  }
  PlateLargeModel::Params params{.radius = membrane.radius,
                                 .thickness = membrane.thickness,
                                 .young_modulus = material.young_modulus,
                                 .poisson_ratio = material.poisson_ratio,
                                 .prestress = scene.model.prestress};
  if (scene.model.modes > 0) params.order = scene.model.modes;
  return std::make_unique<PlateLargeModel>(params);
}

}  // namespace

std::unique_ptr<SurfaceBody> MakeSurfaceBody(const Scene& scene) {
  const double width = scene.tool ? scene.tool->width : 0;
  const std::string kind = ChooseModel(scene).kind;
  if (const auto* membrane = std::get_if<MembraneGeometry>(&scene.object.geometry)) {
    if (kind == "plate" || kind == "plate-large") {
      return std::make_unique<PlateBody>(MakePlate(scene, *membrane, kind), width);
    }
    throw std::invalid_argument("model.kind = " + kind +
                                ": accepted for a membrane under the eyes is plate, plate-large");
  }
  return MakeVolumeBody(scene, width);
}

}  // namespace palpate
