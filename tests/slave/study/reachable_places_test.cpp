#include "slave/study/reachable_places.h"

#include <algorithm>

#include <gtest/gtest.h>

#include "tests/slave/study/fake_model_factory.h"

namespace palpate::study {
namespace {

constexpr double kProbeWidth = 0.01;

Scene Rectangle() {
  Scene scene = fake::Square();
  scene.object.geometry = RectangleGeometry{0.1, 0.06, 0.01};
  scene.object.fixed = {{FixedSide{"bottom"}, {true, true, true}}};
  return scene;
}

// Places keep half a width from both ends: on the left, top and right sides in proportion to their
// lengths.
TEST(ReachablePlacesTest, LieBesideCornersAndWhatIsHeld) {
  const auto places = ReachablePlaces(Rectangle(), kProbeWidth, SpreadShares(50));
  ASSERT_EQ(places.size(), 50U);
  int on_top = 0;
  for (const Eigen::Vector3d& p : places) {
    const bool top = std::abs(p.y() - 0.06) < 1e-9;
    on_top += top ? 1 : 0;
    const double along = top ? p.x() : p.y(), length = top ? 0.1 : 0.06;
    EXPECT_TRUE(top || std::abs(p.x() * (p.x() - 0.1)) < 1e-12) << p.transpose();
    EXPECT_GE(along, 0.98 * kProbeWidth);
    EXPECT_LE(along, length - 0.98 * kProbeWidth);
  }
  EXPECT_NEAR(on_top, 50 * 80 / (80 + 2 * 40), 2);
}

// Reference: the area where a disc of 20 mm fits on the cube at a distance of 20 mm from the
// supports: 40 x 40 mm of its top, 40 x 30 mm of each side. Tolerance: two sigma of 50 among 200.
// In an earlier version shares on the fixed face gave the same place many times.
TEST(ReachablePlacesTest, GoEvenlyOverWhereTheToolRestsNoneTwice) {
  Scene scene = Rectangle();
  scene.object.geometry = BoxGeometry{{0.06, 0.06, 0.06}, {3, 3, 3}};
  scene.object.fixed = {{FixedPlane{2, 0}, {true, true, true}}};
  const auto places = ReachablePlaces(scene, 0.02, SpreadShares(200));
  ASSERT_EQ(places.size(), 200U);
  int on_top = 0;
  for (std::size_t i = 0; i < places.size(); ++i) {
    on_top += places[i].z() > 0.0599 ? 1 : 0;
    for (std::size_t k = 0; k < i; ++k) EXPECT_GT((places[i] - places[k]).norm(), 1e-6);
  }
  EXPECT_NEAR(on_top, 50, 13);
}

// One place says little about the others. Places in the scene are kept. A tool that is too wide
// fits nowhere: then the place where the tool would meet the object is used.
TEST(ReachablePlacesTest, DecideForTheWholeObject) {
  Scene scene = Rectangle();
  scene.tool->width = kProbeWidth;
  EXPECT_EQ(PlacesToStudy(scene).size(), 128U);
  scene.study_contacts = {{0.02, 0.06, 0}};
  EXPECT_TRUE(PlacesToStudy(scene).empty());
  scene.study_contacts.clear();
  scene.tool->width = 0.09;
  EXPECT_TRUE(PlacesToStudy(scene).empty());
}

}  // namespace
}  // namespace palpate::study
