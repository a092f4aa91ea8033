// The truth of a simulated embryo, in addition to that of its disc.
#include <set>

#include <gtest/gtest.h>
#include <opencv2/core.hpp>

#include "slave/simulator/camera/embryo.h"
#include "slave/simulator/camera/scripted_press.h"
#include "slave/simulator/camera/simulated_site.h"
#include "tests/slave/reference/planar/planar_scenes.h"

namespace palpate {
namespace {

constexpr double kSiteRadius = 0.6e-3;

Scene LivingScene(std::uint32_t seed = 1) {
  Scene scene = simulation::EmbryoScene();
  scene.site.seed = seed;
  scene.site.embryo.emplace();
  return scene;
}

// Moves straight in from the right to `depth` [m], in steps of half a micrometre.
void PressTo(SimulatedSite& site, double depth) {
  for (double x = 0.62e-3; x > kSiteRadius - depth; x -= 0.5e-6) site.MoveTool({x, 0, 0});
  site.MoveTool({kSiteRadius - depth, 0, 0});
}
void Retreat(SimulatedSite& site) {
  for (double x = site.truth().p_S_tip.x(); x < 0.65e-3; x += 0.5e-6) site.MoveTool({x, 0, 0});
}

// Reference: the same disc without the law of the embryo, which is linear (its own tests), and the
// stated law. Tolerance: rounding.
TEST(EmbryoSiteTest, TheMembraneIsLinearToItsDepthAndStiffensBeyond) {
  Scene scene = LivingScene();
  scene.site.embryo->puncture = {1e-2, 1e-2};
  SimulatedSite embryo(scene), disc(simulation::EmbryoScene());
  for (const double depth : {30e-6, 80e-6, 150e-6, 200e-6}) {
    PressTo(embryo, depth);
    PressTo(disc, depth);
    const double beyond = std::max(0.0, embryo.truth().depth / 100e-6 - 1);
    EXPECT_NEAR(embryo.truth().force.x() / disc.truth().force.x(), 1 + 0.3 * beyond * beyond, 1e-9);
    Retreat(embryo);
    Retreat(disc);
  }
}

TEST(EmbryoSiteTest, BreaksBetweenTheDepthsAndHasNoForceUntilTheToolIsOut) {
  std::set<double> depths;
  for (const std::uint32_t seed : {1U, 2U, 3U}) {
    SimulatedSite site(LivingScene(seed));
    for (int insertion = 0; insertion < 2; ++insertion) {
      PressTo(site, 40e-6);
      EXPECT_FALSE(site.truth().punctured);
      EXPECT_GT(site.truth().force.x(), 0.01);
      double broke = 0;
      for (double depth = 40e-6; depth < 300e-6; depth += 1e-6) {
        site.MoveTool({kSiteRadius - depth, 0, 0});
        if (site.truth().punctured && broke == 0) broke = depth;
        if (broke > 0) EXPECT_EQ(site.truth().force.norm(), 0) << depth;
      }
      EXPECT_GT(broke, 50e-6);
      EXPECT_LT(broke, 202e-6);
      depths.insert(broke);
      site.MoveTool({kSiteRadius - 20e-6, 0, 0});  // nearly out
      EXPECT_TRUE(site.truth().punctured);
      Retreat(site);
      EXPECT_FALSE(site.truth().punctured);
    }
  }
  EXPECT_EQ(depths.size(), 6U) << "every insertion breaks at a depth of its own";
}

}  // namespace
}  // namespace palpate
