#include "slave/pipeline/points/points_overlay.h"

#include <limits>

#include <gtest/gtest.h>

#include "tests/slave/pipeline/points/watched_membrane.h"

namespace palpate {
namespace {

using testing_fakes::DotPairs;
using testing_fakes::MembraneScene;

class PointsOverlayTest : public ::testing::Test {
 protected:
  PointsOverlayTest()
      : scene_(MembraneScene()), tracker_(MakeSurfacePointTracker(scene_, RigOf(scene_))) {
    while (!tracker_->at_rest_known()) tracker_->Process(pair_);
  }
  Scene scene_;
  std::unique_ptr<SurfacePointTracker> tracker_;
  StereoPair pair_ = DotPairs().Draw({}, 1);
};

TEST_F(PointsOverlayTest, NumbersThatAreNoneAndPlacesFarOutDrawNothingAndBreakNothing) {
  ContactEstimate estimate;
  estimate.depth = 0.001;
  estimate.force = Eigen::Vector3d(0, 0, 1e300);
  estimate.p_S_contact = {1e6, -1e6, 0.3};
  const SurfaceObservation& seen = tracker_->Process(pair_);
  EXPECT_EQ(DrawPoints(pair_.left, MakePointsOverlay(*tracker_, seen, estimate), 0).rows, 480);
  EXPECT_EQ(DrawPoints(pair_.left, MakePointsOverlay(*tracker_, seen, estimate), 1).rows, 480);
  estimate.p_S_contact.setConstant(std::numeric_limits<double>::quiet_NaN());
  EXPECT_FALSE(MakePointsOverlay(*tracker_, seen, estimate).place_I.has_value());
}

}  // namespace
}  // namespace palpate
