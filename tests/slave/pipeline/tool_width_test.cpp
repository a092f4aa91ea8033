// A flat tool on boundary elements, which it covers in part.
#include <cmath>
#include <span>

#include <gtest/gtest.h>

#include "slave/mechanics/factory/make_model.h"
#include "slave/mechanics/object_mesh.h"
#include "slave/pipeline/camera/touch_model.h"
#include "slave/scene/scene_loader.h"
#include "tests/support/paths.h"

namespace palpate {
namespace {

struct Stiffness {
  double raw = 0, corrected = 0, sigma = 0;  // along the normal [N/m]; relative
};

Stiffness StiffnessOf(int elements, double width) {
  Scene scene = LoadScene(SourcePath("/deploy/scenes/silicone-block.yaml"));
  scene.model.elements = elements;
  scene.tool->width = width;
  const BoundaryMesh mesh = MeshOutline(scene, std::nullopt);
  const auto model = MakeModel(scene, mesh);
  BoundaryContact contact(mesh, 0);
  contact.Move({0.04, 0.09});
  const BoundaryPlace place = contact.Move({0.04, 0.087});
  const Contact patch{
      Contact::Kind::kDisplacement, {place.p_O.x(), place.p_O.y(), 0}, place.element, width};
  ContactResponse response;
  model->Respond(std::span(&patch, 1), std::span(&response, 1));
  ToolWidth tool(mesh, scene);
  const ToolWidth::Share share = tool.At(place, model.get());
  const double K = response.stiffness_O(1, 1);
  return {K, share.factor * K, share.sigma};
}

// Reference: the stiffness of the block must not depend on the number of elements. The finest mesh,
// with 20 elements under the tool, represents the true value. The difference is within three of the
// stated sigmas, which are small.
TEST(ToolWidthTest, TheDivisionDoesNotMatter) {
  constexpr double kWidth = 5.87e-3;
  const double truth = StiffnessOf(1200, kWidth).corrected;
  double worst = 0;
  for (const int elements : {90, 110, 130, 150, 180, 210, 240, 300}) {
    const Stiffness K = StiffnessOf(elements, kWidth);
    EXPECT_NEAR(K.corrected / truth, 1, 3 * K.sigma) << elements << " elements";
    EXPECT_LT(K.sigma, 0.02) << elements << " elements";
    worst = std::max(worst, std::abs(K.raw / truth - 1));
  }
  EXPECT_LT(worst, 0.01);
}

}  // namespace
}  // namespace palpate
