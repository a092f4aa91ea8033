// A robot presses a real air-filled membrane while a depth camera watches from inside. Reference:
// the wrench measured at the robot, against its mean over frames 40 to 58, before the contact.
#include <algorithm>
#include <cmath>
#include <filesystem>
#include <optional>

#include <gtest/gtest.h>

#include "shared/state/driven_clock.h"
#include "slave/pipeline/points/points_sense.h"
#include "tests/slave/pipeline/press/press_recording.h"

namespace palpate {
namespace {

namespace fs = std::filesystem;

constexpr int kLastTraining = 65;
// The plane of the rim: the skin ends at its mount, whose depth does not change.
constexpr double kRim = 0.058;          // z of the camera's frame [m]
constexpr double kRubberPoisson = 0.5;  // rubber
constexpr std::size_t kRestImages = 5;
constexpr double kWrench = 0.2;  // noise of the force sensor [N]

Scene RecordedScene();

struct Replayed {
  int frame = 0;
  ContactEstimate estimate;
  Eigen::Vector3d p_S_deepest{0, 0, 0};  // point with the largest displacement inward, at rest
};

class RealPressTest : public ::testing::Test {
 protected:
  static void SetUpTestSuite() {
    if (!fs::exists(RecordedPressFolder() / "robot_pressure_wrench.csv")) return;
    press_ = new RecordedPress(ReadRecordedPress(RecordedPressFolder()));
  }
  static void TearDownTestSuite() {
    delete press_;
    press_ = nullptr;
  }
  void SetUp() override {
    if (press_ == nullptr) GTEST_SKIP() << RecordedPressFolder() << " is not there";
  }

  // The orientation of the force sensor is unknown, so only the magnitude of the change is used.
  static double Measured(int frame) {
    return press_->rows[static_cast<std::size_t>(frame)].force.norm();
  }
  // Estimates from the recorded scene, after its rest frame.
  static std::vector<Replayed> Replay() {
    const DrivenClock clock;
    PointsSense sense(RecordedScene(), SenseInputs{});
    std::vector<Replayed> replayed;
    for (std::size_t i = 0; sense.Acquire({}); ++i) {
      sense.Process();
      const ContactEstimate& estimate = sense.Estimate({{0, 0, 0.2}, std::nullopt});
      if (!estimate.force) continue;
      const auto inward = [](const SurfacePoint& point) {
        return point.seen ? point.p_S_rest.z() - point.p_S.z() : 0.0;
      };
      const SurfacePoint& deepest =
          *std::ranges::max_element(sense.observation().points, {}, inward);
      replayed.push_back({press_->frames.at(i - kRestImages).number, estimate, deepest.p_S_rest});
    }
    return replayed;
  }

  static RecordedPress* press_;
};

RecordedPress* RealPressTest::press_ = nullptr;

// Compares the covariance stated by DepthPoints with the noise of its points without contact: it
// must not be too small, and at most twice too large.
TEST_F(RealPressTest, AtRestThePointsScatterAsTheirSigmaSays) {
  EXPECT_LT(press_->rest_scatter, 1.1);
  EXPECT_GT(press_->rest_scatter, 0.5);
  EXPECT_LT(press_->rest_rms, 0.06e-3);
}

// The ellipsoid that fits the points at rest above the rim to 0.3 mm; modulus and tension fitted to
// the frames up to 65; the enclosed air that gives the pressure measured at the deepest contact.
Scene RecordedScene() {
  constexpr double kWallThickness = 0.5e-3;
  Scene scene;
  scene.object.geometry = DomeGeometry{{70e-3, 49.6e-3, 71e-3}, 42.4e-3, kWallThickness, 0.6e-3};
  scene.object.X_SO.translation() = Eigen::Vector3d(29.7e-3, 0.1e-3, kRim);
  scene.object.material = {.young_modulus = 1212 / kWallThickness, .poisson_ratio = kRubberPoisson};
  scene.tool = Tool{.width = 0.014};
  scene.model.kind = "membrane";
  scene.model.prestress = 295;
  PointsOptions points{RecordedPressCamera().camera, {.track = PointTracking::Track::kSurface}};
  std::get<DepthImages>(points.cameras).pattern = (RecordedPressFolder() / "depth_*.png").string();
  scene.sense.Set(points);
  return scene;
}

// The tool is stationary from frame 74 on, so must be its position; and it lies under the
// indentation: the load and the deepest point differ where the load is eccentric, by less than the
// tool's width.
TEST_F(RealPressTest, TheContactStaysWhereTheToolIsStationary) {
  std::optional<Eigen::Vector3d> first;
  for (const Replayed& one : Replay()) {
    if (one.frame < 70 || one.frame > 95) continue;
    EXPECT_LT((one.p_S_deepest - one.estimate.p_S_contact).norm(), 8e-3) << one.frame;
    if (one.frame < 74) continue;
    if (!first) first = one.estimate.p_S_contact;
    EXPECT_LT((*first - one.estimate.p_S_contact).norm(), 0.5e-3) << one.frame;
  }
  EXPECT_TRUE(first) << "no frame of the stationary tool";
}

// Tolerance: the root of the sum of the squares of 8 % of the peak and 8 % for the modelled air.
TEST_F(RealPressTest, TheForceFollowsTheWrenchOnLaterFrames) {
  double square = 0, peak = 0;
  int judged = 0, valid = 0, within = 0;
  for (const Replayed& one : Replay()) {
    const ContactEstimate& estimate = one.estimate;
    const double error = estimate.force->norm() - Measured(one.frame);
    peak = std::max(peak, Measured(one.frame));
    if (one.frame <= kLastTraining) continue;
    square += error * error;
    ++judged;
    valid += estimate.validity == Validity::kValid;
    within += std::abs(error) < 2 * std::hypot(estimate.sigma, kWrench);
  }
  ASSERT_GT(judged, 5);
  const double share = std::sqrt(square / judged) / peak;
  EXPECT_LT(share, 0.113);
  EXPECT_EQ(valid, judged);
  EXPECT_GE(within, 0.8 * judged);
}

}  // namespace
}  // namespace palpate
