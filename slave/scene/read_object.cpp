#include <cmath>

#include "slave/scene/sections.h"

namespace palpate {
namespace {

Material ReadMaterial(Section& object) {
  Section section = object.Open("material", "a map of young_modulus, poisson_ratio, ...");
  Material material;
  material.young_modulus = section.Number("young_modulus", Positive(Dimension::kPressure));
  // Just above -1 the plane's stiffness is still a number.
  material.poisson_ratio =
      section.Number("poisson_ratio",
                     Between(Dimension::kNumber, std::nextafter(-1.0, 0.0), 0.5, "-1 < nu <= 0.5"));
  material.density = section.Number("density", Positive(Dimension::kDensity), 0.0);
  material.young_modulus_tolerance =
      section.Number("tolerance", Between(Dimension::kNumber, 0, 1, "0 to 1"), 0.0);
  return material;
}

}  // namespace

Object ReadObject(Section& scene, const SceneContext& context) {
  Section section = scene.Open("object", "a map of geometry, material, fixed, ...");
  Object object;
  object.geometry = ReadGeometry(section, context);
  const auto at_origin = Eigen::Isometry3d::Identity();
  object.X_SO =
      IsPlanar(object.geometry) ? ReadPlanarPose(section, at_origin) : ReadPose(section, at_origin);
  object.material = ReadMaterial(section);
  object.fixed = ReadFixed(section, object.geometry);
  return object;
}

}  // namespace palpate
