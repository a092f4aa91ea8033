#include "slave/checks/points/epipolar.h"

#include <algorithm>
#include <cmath>
#include <functional>
#include <numbers>
#include <random>

#include <gtest/gtest.h>

#include "tests/slave/vision/stereo/test_rigs.h"
#include "tests/support/allocation_count.h"

namespace palpate {
namespace {

using Eigen::Vector2d;
using Eigen::Vector3d;

constexpr double kImageNoise = 0.01;  // noise of an image position, per axis [px]
constexpr int kImagesAtRest = 10;
constexpr double kPairPeriod = 1.0 / 30;  // [s]

// 35 points on a membrane that is indented at its centre, with errors of the cameras that see them.
class Watched {
 public:
  // Depths of the indentation [m] that the left and the right image show.
  SurfaceObservation& Show(double left_depth, double right_depth) {
    seen_.sensed_at += Seconds(kPairPeriod);
    seen_.skew = -reported_late * kPairPeriod;  // a late image was taken earlier
    seen_.points.resize(35);
    for (std::size_t i = 0; i < seen_.points.size(); ++i) {
      const Vector3d rest(0.01 * (static_cast<double>(i % 7) - 3),
                          0.01 * (static_cast<double>(i / 7) - 2), 0.25);
      const double indentation =
          std::exp(-(rest - Vector3d(0, 0.005, 0.25)).squaredNorm() / 2.5e-4);
      const auto at = [&](double depth) {
        return Vector3d(rest - depth * indentation * Vector3d::UnitZ());
      };
      SurfacePoint& point = seen_.points[i];
      point.left_I = *Project(rig_.left, at(left_depth)) + Noise();
      point.right_I = *Project(rig_.right, rig_.X_RL * at(right_depth)) + Noise();
      if (spoil) point.right_I = spoil(point.right_I);
      const auto met = Triangulate(rig_, point.left_I, point.right_I, kStated);
      point.seen = true;
      point.sigma_px = kImageNoise;
      point.miss_px = met->miss_px;
      point.covariance = met->covariance;
    }
    return seen_;
  }
  // Observes a still membrane until the rest state is known, and once more.
  void Rest() {
    for (int i = 0; i <= kImagesAtRest; ++i) Process(0, 0);
  }
  FailedCheck Process(double left_depth, double right_depth) {
    return Examine(&Show(left_depth, right_depth));
  }
  FailedCheck Examine(SurfaceObservation* seen) {
    Findings findings;
    check_.Examine({{}, {}, *seen}, &findings);
    return findings.verdict.check;
  }
  // Returns the first flag during a press to 5 mm in 20 images and a hold of 20 images; the right
  // image is `late` images late.
  FailedCheck Press(int late) {
    const auto depth = [](int image) { return 2.5e-4 * std::clamp(image, 0, 20); };
    for (int i = 0; i < 40; ++i) {
      const FailedCheck check = Process(depth(i), depth(i - late));
      if (check != FailedCheck::kNone) return check;
    }
    return FailedCheck::kNone;
  }
  // Returns the first flag during repeated presses to 5 mm and back, a dozen images each.
  FailedCheck Swing(double late) {
    const auto depth = [](double image) {
      return 2.5e-3 * (1 - std::cos(std::numbers::pi / 6 * image));
    };
    for (int i = 1; i < 40; ++i) {
      const FailedCheck check = Process(depth(i), depth(i - late));
      if (check != FailedCheck::kNone) return check;
    }
    return FailedCheck::kNone;
  }
  [[nodiscard]] double epipolar_px() const { return seen_.epipolar_px; }    // of the last pair
  [[nodiscard]] double moment_sigma() const { return seen_.moment_sigma; }  // of the last pair
  [[nodiscard]] bool err_by_noise_alone() const {
    return std::ranges::all_of(seen_.points, &SurfacePoint::errs_by_noise_alone);
  }

  static constexpr double kStated = 0.03;  // [px]
  std::function<Vector2d(const Vector2d&)> spoil;

 private:
  Vector2d Noise() {
    const double y =
        normal_(random_);  // the order of a call's arguments would be the compiler's own
    return noise * kImageNoise * Vector2d(normal_(random_), y);
  }

 public:
  double noise = 1;
  double reported_late = 0;  // the right image, by its stamp [images]

 private:
  StereoRig rig_ = VergedTestRig();
  EpipolarCheck check_{rig_, kImagesAtRest, kStated};
  SurfaceObservation seen_;
  std::mt19937 random_{1};
  std::normal_distribution<double> normal_;
};

TEST(EpipolarCheckTest, APressThatBothCamerasSeeAtOnceIsNotFlagged) {
  Watched watched;
  watched.Rest();
  EXPECT_EQ(watched.Press(0), FailedCheck::kNone);
  // The four fitted unknowns absorb their share of the 35 misses, whose noise is that of two
  // positions.
  EXPECT_NEAR(watched.epipolar_px(), kImageNoise * std::hypot(1, std::sqrt(2 * 4 / 35.0)),
              0.4 * kImageNoise);
}

TEST(EpipolarCheckTest, ImagesOfDifferentInstantsAreFlaggedWhileThePressMoves) {
  for (const int late : {1, 2, 5, -1, -5, 1000}) {
    Watched watched;
    watched.Rest();
    EXPECT_EQ(watched.Press(late), FailedCheck::kInstants) << late;
  }
}

// Reference: the simulated delay. The stated time of a pair is wrong by half of the delay that the
// timestamps do not show. The stated noise of 40 pairs leaves an uncertainty of 0.02 image periods.
// Tolerance: the speed is that of half an image earlier, which changes the result by up to a
// quarter.
TEST(EpipolarCheckTest, TheTimesSigmaFollowsFromTimestampErrors) {
  for (const double late : {0.0, 0.08, -0.08}) {
    for (const double reported : {0.0, 0.08, -0.08}) {
      Watched watched;
      watched.reported_late = reported;
      watched.Rest();
      EXPECT_NEAR(watched.moment_sigma(), PointsLimits::kMaxLag / 2, 1e-12) << "nothing moved yet";
      watched.noise = 0.1;
      EXPECT_EQ(watched.Swing(late), FailedCheck::kNone) << late << " " << reported;
      EXPECT_NEAR(watched.moment_sigma(), std::hypot((late - reported) / 2, 0.02), 0.015)
          << late << " " << reported;
    }
  }
}

TEST(EpipolarCheckTest, WrongTimestampsAreFlagged) {
  Watched watched;
  watched.reported_late = -0.15;
  watched.Rest();
  EXPECT_EQ(watched.Swing(0.15), FailedCheck::kInstants);
}

TEST(EpipolarCheckTest, ACameraThatIsBumpedAcrossIsFlagged) {
  for (const bool turns : {false, true}) {
    Watched watched;
    watched.Rest();
    watched.spoil = [turns](const Vector2d& p) {
      return turns ? Vector2d(p.x(), p.y() + 0.01 * (p.x() - 320)) : Vector2d(p.x(), p.y() + 1);
    };
    EXPECT_EQ(watched.Process(0, 0), FailedCheck::kEpipolar);
    EXPECT_EQ(watched.Process(3e-3, 3e-3), FailedCheck::kEpipolar);
    EXPECT_GT(watched.epipolar_px(), 0.5);
  }
}

// Reference: the noise drawn, three and ten times the stated one.
TEST(EpipolarCheckTest, NoiseBeyondThatOfTheImagesWidensTheCovariances) {
  for (const double more : {1.0, 9.0, 30.0}) {
    Watched watched;
    watched.Rest();
    watched.noise = more;
    SurfaceObservation& seen = watched.Show(1e-3, 1e-3);
    const double reported = seen.points[7].covariance(2, 2);
    EXPECT_EQ(watched.Examine(&seen), FailedCheck::kNone) << more;
    const double wider = std::sqrt(seen.points[7].covariance(2, 2) / reported);
    EXPECT_NEAR(wider, std::max(1.0, more * kImageNoise / Watched::kStated), 0.4 * wider) << more;
  }
}

// Noise of 0.4 and 1 times the stated value is accepted as the only error; 0.1 and 1.5 times are
// not. 300 ray distances determine the noise within a twentieth.
TEST(EpipolarCheckTest, PointsErrByNoiseAloneIfTheyScatterByItAtRest) {
  for (const double more : {0.1, 0.4, 1.0, 1.5}) {
    Watched watched;
    watched.noise = more;
    watched.Process(0, 0);
    EXPECT_FALSE(watched.err_by_noise_alone()) << "of one pair nobody can tell";
    watched.Rest();
    EXPECT_EQ(watched.err_by_noise_alone(), 0.2 < more && more <= 1) << more;
  }
}

// One displaced dot or hidden dots do not indicate a fault of the cameras.
TEST(EpipolarCheckTest, OneDisplacedPointIsNoMotion) {
  Watched watched;
  watched.Rest();
  for (int i = 0; i < 20; ++i) {
    SurfaceObservation& seen = watched.Show(2e-4 * i, 2e-4 * i);
    seen.points[17].miss_px += 2;
    for (const std::size_t hidden : {1U, 9U, 30U}) seen.points[hidden].seen = false;
    ASSERT_EQ(watched.Examine(&seen), FailedCheck::kNone) << i;
  }
}

TEST(EpipolarCheckTest, APairAllocatesNothing) {
  Watched watched;
  watched.Rest();
  SurfaceObservation& seen = watched.Show(1e-3, 1e-3);
  const long before = AllocationCount();
  watched.Examine(&seen);
  EXPECT_EQ(AllocationCount(), before);
}

}  // namespace
}  // namespace palpate
