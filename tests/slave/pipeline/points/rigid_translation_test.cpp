#include <gtest/gtest.h>

#include "slave/pipeline/points/surface_estimator.h"
#include "tests/support/allocation_count.h"

namespace palpate {
namespace {

using Eigen::Vector3d;

// Four points of a body that has moved by `way`.
SurfaceObservation SeenShifted(const Vector3d& way) {
  SurfaceObservation seen;
  seen.found = true;
  for (int i = 0; i < 4; ++i) {
    SurfacePoint point;
    point.id = i;
    point.seen = true;
    point.p_S_rest = Vector3d(0.01 * i, 0.002 * i * i, 0.2);
    point.p_S = point.p_S_rest + way;
    seen.points.push_back(point);
  }
  return seen;
}

const Vector3d kMean(0.015, 0.007, 0.2);  // of the four at rest

TEST(TrackedPlaceTest, ABodyThatDoesNotTurnIsFollowedWhicheverPointsAreHidden) {
  RigidTranslation place;
  EXPECT_TRUE(place.Estimate(SeenShifted({0, 0, 0})).p_S_contact.isApprox(kMean, 1e-12));
  const Vector3d way(0.004, -0.003, 0.01);
  for (unsigned hidden = 0; hidden < 15; ++hidden) {
    SurfaceObservation seen = SeenShifted(way);
    for (std::size_t i = 0; i < 4; ++i) seen.points[i].seen = (hidden >> i & 1U) == 0;
    const ContactEstimate& estimate = place.Estimate(seen);
    EXPECT_TRUE(estimate.p_S_contact.isApprox(kMean + way, 1e-12)) << hidden;
    EXPECT_TRUE(place.moved().isApprox(way, 1e-12));
    EXPECT_FALSE(estimate.force.has_value());
    EXPECT_EQ(estimate.validity, Validity::kFailed);  // the force is unknown, the place is not
  }
}

// A point that enters the view later has a rest position from a later time.
TEST(TrackedPlaceTest, PointsThatCameLaterDoNotCount) {
  RigidTranslation place;
  SurfaceObservation first = SeenShifted({0, 0, 0});
  first.points[3].seen = false;
  const Vector3d start = place.Estimate(first).p_S_contact;
  SurfaceObservation seen = SeenShifted({0.01, 0, 0});
  seen.points[3].p_S_rest = seen.points[3].p_S;
  EXPECT_TRUE(place.Estimate(seen).p_S_contact.isApprox(start + Vector3d(0.01, 0, 0), 1e-12));
}

TEST(TrackedPlaceTest, ALossIsReportedAndSoIsItsEnd) {
  RigidTranslation place;
  EXPECT_EQ(place.estimate().validity, Validity::kFailed);
  const Vector3d start = place.Estimate(SeenShifted({0, 0, 0})).p_S_contact;
  SurfaceObservation nothing = SeenShifted({0.01, 0, 0});
  nothing.found = false;
  const ContactEstimate& lost = place.Estimate(nothing);
  EXPECT_EQ(lost.validity, Validity::kTrackingLost);
  EXPECT_TRUE(lost.events.Has(Event::kTrackingLost));
  EXPECT_TRUE(lost.p_S_contact.isApprox(start));  // the last known one
  EXPECT_FALSE(place.Estimate(nothing).events.Has(Event::kTrackingLost));
  const ContactEstimate& again = place.Estimate(SeenShifted({0.01, 0, 0}));
  EXPECT_EQ(again.validity, Validity::kFailed);
  EXPECT_TRUE(again.events.Has(Event::kTrackingRegained));
  place.Reset();
  EXPECT_TRUE(
      place.Estimate(SeenShifted({0.02, 0, 0})).p_S_contact.isApprox(kMean + Vector3d(0.02, 0, 0)));
}

TEST(TrackedPlaceTest, EstimatingDoesNotAllocateAfterTheFirstObservation) {
  RigidTranslation place;
  const SurfaceObservation seen = SeenShifted({0.001, 0, 0});
  place.Estimate(seen);
  const long before = AllocationCount();
  for (int i = 0; i < 100; ++i) place.Estimate(seen);
  EXPECT_EQ(AllocationCount(), before);
}

}  // namespace
}  // namespace palpate
