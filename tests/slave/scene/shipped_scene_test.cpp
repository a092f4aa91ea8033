#include <gtest/gtest.h>

#include "slave/scene/scene_loader.h"
#include "tests/support/paths.h"

namespace palpate {
namespace {

// Reference b, disc of 100 elements, plane strain, nu 0.5: 0.651 N per um and metre of thickness on
// a patch of 38 um, so 200 um of the 1.2 mm thick disc, where the chorion breaks at the latest, are
// 156 mN.
TEST(ShippedSceneTest, TheEmbryosLargestForceStaysWithinTheForceLimit) {
  const Scene scene = LoadScene(SourcePath("/deploy/scenes/zebrafish-embryo.yaml"));
  const double force =
      0.6511619520953413e6 * scene.site.embryo->puncture[1] * ThicknessOf(scene.object.geometry);
  const double rendered = scene.operator_options.transform.force_scale * force;
  EXPECT_LT(rendered, scene.operator_options.force_limit);
  EXPECT_GT(rendered, 0.5 * scene.operator_options.force_limit);
}

}  // namespace
}  // namespace palpate
