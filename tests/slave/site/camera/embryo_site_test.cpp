// What is true of a simulated embryo beside the disc that it is.
#include <set>
#include <vector>

#include <gtest/gtest.h>
#include <opencv2/core.hpp>

#include "slave/site/camera/embryo.h"
#include "slave/site/camera/scripted_press.h"
#include "slave/site/camera/simulated_site.h"
#include "tests/slave/site/camera/site_scenes.h"

namespace palpate {
namespace {

constexpr double kRadius = 0.6e-3;

Scene LivingScene(std::uint32_t seed = 1) {
  Scene scene = site::EmbryoScene();
  scene.site.seed = seed;
  scene.site.embryo.emplace();
  return scene;
}

// Straight in from the right to `depth` [m], in steps of half a micrometre.
void PressTo(SimulatedSite& site, double depth) {
  for (double x = 0.62e-3; x > kRadius - depth; x -= 0.5e-6) site.MoveTool({x, 0, 0});
  site.MoveTool({kRadius - depth, 0, 0});
}
void Retreat(SimulatedSite& site) {
  for (double x = site.truth().p_S_tip.x(); x < 0.65e-3; x += 0.5e-6) site.MoveTool({x, 0, 0});
}

// Reference: the same disc without a life of its own, which is linear (its own tests), and the
// stated law. To rounding.
TEST(EmbryoSiteTest, TheMembraneIsLinearToItsDepthAndStiffensBeyond) {
  Scene scene = LivingScene();
  scene.site.embryo->puncture = {1e-2, 1e-2};
  SimulatedSite embryo(scene), disc(site::EmbryoScene());
  for (const double depth : {30e-6, 80e-6, 150e-6, 200e-6}) {
    PressTo(embryo, depth);
    PressTo(disc, depth);
    const double beyond = std::max(0.0, embryo.truth().depth / 100e-6 - 1);
    EXPECT_NEAR(embryo.truth().force.x() / disc.truth().force.x(), 1 + 0.3 * beyond * beyond, 1e-9);
    Retreat(embryo);
    Retreat(disc);
  }
}

TEST(EmbryoSiteTest, ItBreaksBetweenTheDepthsAndPushesNoMoreUntilTheToolIsOut) {
  std::set<double> depths;
  for (const std::uint32_t seed : {1U, 2U, 3U}) {
    SimulatedSite site(LivingScene(seed));
    for (int insertion = 0; insertion < 2; ++insertion) {
      PressTo(site, 40e-6);
      EXPECT_FALSE(site.truth().punctured);
      EXPECT_GT(site.truth().force.x(), 0.01);
      double broke = 0;
      for (double depth = 40e-6; depth < 300e-6; depth += 1e-6) {
        site.MoveTool({kRadius - depth, 0, 0});
        if (site.truth().punctured && broke == 0) broke = depth;
        if (broke > 0) EXPECT_EQ(site.truth().force.norm(), 0) << depth;
      }
      EXPECT_GT(broke, 50e-6);
      EXPECT_LT(broke, 202e-6);
      depths.insert(broke);
      site.MoveTool({kRadius - 20e-6, 0, 0});  // nearly out
      EXPECT_TRUE(site.truth().punctured);
      Retreat(site);
      EXPECT_FALSE(site.truth().punctured);
    }
  }
  EXPECT_EQ(depths.size(), 6U) << "every insertion breaks at a depth of its own";
}

// The outline that is seen springs back: the picture of a punctured embryo is that of one at rest
// but for the tool.
TEST(EmbryoSiteTest, ThePictureOfAPuncturedEmbryoIsThatOfOneAtRest) {
  Scene scene = LivingScene();
  scene.site.noise = 0;
  scene.site.flicker = 0;
  scene.site.embryo->debris = 0;
  scene.site.embryo->defocus = 0;
  SimulatedSite site(scene);
  const cv::Mat rest = site.TakePicture();
  PressTo(site, 45e-6);
  const cv::Mat pressed = site.TakePicture();
  PressTo(site, 250e-6);
  const cv::Mat punctured = site.TakePicture();
  // The rim beside the tool, 20 um above it: column of x = 0.6 mm.
  const cv::Rect beside(520 - 25, 240 - 20, 40, 8);
  EXPECT_GT(cv::norm(rest(beside), pressed(beside), cv::NORM_INF), 30);
  EXPECT_LT(cv::norm(rest(beside), punctured(beside), cv::NORM_INF), 2);
}

// What the liquid does to a moving tool, and to a still one.
TEST(EmbryoSiteTest, TheLiquidDragsTheToolBack) {
  Scene scene = LivingScene();
  scene.site.embryo->drag = 0.5;
  SimulatedSite site(scene);
  site.TakePicture();
  site.MoveTool({0.69e-3, 0, 0});  // 10 um to the left within a picture of 1/60 s
  site.TakePicture();
  EXPECT_NEAR(site.truth().force.x(), 0.5 * 10e-6 * 60, 1e-9);
  site.TakePicture();
  EXPECT_EQ(site.truth().force.norm(), 0);
}

TEST(EmbryoSiteTest, TargetsLieInsideByTheSeedAndTheScriptReachesThem) {
  std::set<double> places;
  for (std::uint32_t seed = 1; seed <= 20; ++seed) {
    const Eigen::Vector3d target = site::TargetOf(LivingScene(seed));
    EXPECT_LT(target.norm(), 0.5 * kRadius);
    EXPECT_EQ(target, site::TargetOf(LivingScene(seed)));
    places.insert(target.x());
  }
  EXPECT_EQ(places.size(), 20U);
  const Scene scene = LivingScene(7);
  SimulatedSite site(scene);
  const ScriptedPress press(scene);
  EXPECT_LT((press.Tip(press.hold_begin()) - site.goal().value()).norm(), 1e-9);
  EXPECT_EQ(SimulatedSite(site::EmbryoScene()).goal(), std::nullopt);
}

TEST(EmbryoSiteTest, TheSamePicturesForTheSameSeed) {
  std::vector<cv::Mat> seen;
  for (const std::uint32_t seed : {3U, 3U, 4U}) {
    SimulatedSite site(LivingScene(seed));
    for (int i = 0; i < 5; ++i) seen.push_back(site.TakePicture());
  }
  for (int i = 0; i < 5; ++i) {
    EXPECT_EQ(cv::norm(seen[i], seen[5 + i], cv::NORM_INF), 0) << i;
    EXPECT_GT(cv::norm(seen[i], seen[10 + i], cv::NORM_INF), 0) << i;
  }
}

// An outline that only the picture tells the scene, and the site knows.
TEST(EmbryoSiteTest, AnOutlineFromTheImageIsPlayedWhereTheSiteTellsItsRadius) {
  Scene scene = LivingScene();
  scene.object.geometry = ImageContourGeometry{1.2e-3};
  EXPECT_THROW(SimulatedSite site(scene), std::invalid_argument);
  scene.site.embryo->radius = kRadius;
  SimulatedSite site(scene);
  PressTo(site, 45e-6);
  EXPECT_GT(site.truth().force.x(), 0.01);
}

}  // namespace
}  // namespace palpate
