// An object that moves while it is pressed, or a camera that moves: the estimates and the patch
// sent to the master must move with the object.
#include <cmath>
#include <functional>
#include <memory>
#include <numbers>
#include <optional>
#include <random>

#include <gtest/gtest.h>
#include <opencv2/imgproc.hpp>

#include "shared/patch/patch_contact.h"
#include "slave/live/patch_publisher.h"
#include "slave/pipeline/camera/camera_sense.h"
#include "slave/scene/scene_loader.h"
#include "slave/simulator/camera/simulated_site.h"
#include "slave/vision/observation.h"
#include "tests/slave/simulator/environment_player.h"
#include "tests/support/paths.h"

namespace palpate {
namespace {

using Eigen::Vector3d;

constexpr double kImageRate = 60, kEpoch = 1e6;  // [Hz], [s]

Time At(double t) {
  return Time{} + Seconds(kEpoch + t);
}

// The simulated site of the shipped block. The block can be moved in front of the camera.
class CarriedSite final : public SimulatedEnvironment {
 public:
  explicit CarriedSite(const Scene& scene) : site_(scene) {
    const cv::Mat image = site_.TakeImage();
    view_.emplace(*scene.sense.Find<Camera>(), image.cols, image.rows);
  }
  // Moves the object to `object`, S [m], from its initial position.
  void Carry(const Vector3d& object) {
    object_ = object;
    site_.MoveTool(p_S_tip_ - object_);
  }
  void MoveTool(const Vector3d& p_S_tip,
                WhenUnsolved /*when_unsolved*/ = WhenUnsolved::kWait) override {
    p_S_tip_ = p_S_tip;
    site_.MoveTool(p_S_tip_ - object_);
  }
  [[nodiscard]] Truth truth() const override {
    Truth truth = site_.truth();
    truth.p_S_tip += object_;
    return truth;
  }
  void SolveAhead() override {}
  [[nodiscard]] std::optional<TargetTruth> target() const override { return std::nullopt; }
  [[nodiscard]] std::optional<Eigen::Vector3d> goal() const override { return std::nullopt; }
  [[nodiscard]] Eigen::Vector3d TrueDisplacement(const Eigen::Vector2d& /*p_O*/) const override {
    return Eigen::Vector3d::Zero();
  }
  std::unique_ptr<StereoSource> OpenPair(const Scene& /*scene*/,
                                         const std::optional<ScriptedRun>& /*run*/) override {
    return nullptr;
  }
  std::unique_ptr<TactileSource> OpenFingertips(
      const Scene& /*scene*/, const std::optional<ScriptedRun>& /*run*/) override {
    return nullptr;
  }
  std::unique_ptr<FrameSource> OpenCamera(const Scene& /*scene*/,
                                          const std::optional<ScriptedRun>& /*run*/) override {
    return std::make_unique<Source>(*this);
  }

  double t = 0;  // [s]

 private:
  class Source final : public FrameSource {
   public:
    explicit Source(CarriedSite& site) : site_(site) {}
    std::optional<Frame> Next(const std::stop_token& /*stop*/) override {
      return Frame{site_.Image(), ++sequence_, At(site_.t)};
    }
    [[nodiscard]] std::string description() const override { return "a carried site"; }

   private:
    CarriedSite& site_;
    std::uint64_t sequence_ = 0;
  };
  [[nodiscard]] cv::Mat Image() {
    const Eigen::Vector2d shift = view_->ToImage(object_) - view_->ToImage(Vector3d::Zero());
    const cv::Mat warp = (cv::Mat_<double>(2, 3) << 1, 0, shift.x(), 0, 1, shift.y());
    cv::Mat image;
    cv::warpAffine(site_.TakeImage(), image, warp, {}, cv::INTER_CUBIC, cv::BORDER_REPLICATE);
    return image;
  }

  SimulatedSite site_;
  std::optional<CameraView> view_;
  Vector3d object_{0, 0, 0}, p_S_tip_ = site_.truth().p_S_tip;
};

class MovingObjectTest : public testing::Test {
 protected:
  static constexpr double kAmplitude = 2e-3, kFrequency = 0.4, kDuration = 2.6;  // [m], [Hz], [s]
  static constexpr double kTolerance = 0.08e-3;  // [m]; half a pixel

  static Vector3d MotionAt(double t) {
    return {0, kAmplitude * std::sin(2 * std::numbers::pi * kFrequency * t), 0};
  }
  static Vector3d VelocityAt(double t) { return (MotionAt(t + 1e-4) - MotionAt(t - 1e-4)) / 2e-4; }
  // Moves tool and object, and estimates from the next image.
  const ContactEstimate& Step(const Vector3d& p_S_tip, const Vector3d& object) {
    site_.t += 1 / kImageRate;
    site_.MoveTool(p_S_tip);
    site_.Carry(object);
    EXPECT_TRUE(sense_.Acquire({}));
    const ContactEstimate& estimate = sense_.Estimate({p_S_tip, 0});
    if (keeper_.Get(At(site_.t)).patch || estimate.force) {
      keeper_.Update(estimate, 1, &sense_, At(site_.t));
    }
    return estimate;
  }
  // Presses 4 mm deep. Returns the tool's position, S [m].
  Vector3d Lower() {
    Vector3d p_S = scene_.manipulator.home;
    for (int i = 0; i < 30; ++i) Step(p_S, Vector3d::Zero());
    while (site_.truth().depth < 4e-3) {
      p_S += 2e-4 * Vector3d(scene_.tool->direction.x(), scene_.tool->direction.y(), 0);
      Step(p_S, Vector3d::Zero());
    }
    return p_S;
  }

  // Returns the force that a master with the newest patch renders for the time `then` [s].
  Vector3d ByPatch(const Vector3d& p_S, double then) {
    const PatchSnapshot news = keeper_.Get(At(site_.t));
    const double sensed = SecondsBetween(Time{}, news.law.sensed_at);
    PatchContact shown;
    shown.Take(*news.patch, news.law, sensed, sensed - 1);
    return shown.ForceAt(p_S, kEpoch + then, kEpoch + then);
  }

  const Scene scene_ =
      LoadScene(SourcePath("/deploy/scenes/silicone-block.yaml"), {"model.elements=60"});
  CarriedSite site_{scene_};
  EnvironmentPlayer player_{site_, scene_};
  CameraSense sense_{scene_, {.player = &player_}};
  PatchPublisher keeper_{PatchPublisher::Options{.period = 1 / kImageRate}};
};

// Reference: the simulated site, which does not use images. If the motion were attributed to the
// camera, plane and patch would stay in place: an error of half the peak.
TEST_F(MovingObjectTest, EstimatesAndPatchFollowTheObject) {
  const Vector3d p_S = Lower();
  const double begin = site_.t, peak = site_.truth().force.norm();
  int valid = 0, images = 0;
  double tip = 0, force = 0, plane = 0, patch = 0, square = 0;
  while (site_.t < begin + kDuration) {
    const Vector3d moved = MotionAt(site_.t + 1 / kImageRate - begin);
    const ContactEstimate& estimate = Step(p_S, moved);
    if (site_.t < begin + 0.5) continue;  // it is not known yet whether camera or object moves
    const Truth truth = site_.truth();
    ++images;
    valid += estimate.validity == Validity::kValid ? 1 : 0;
    tip = std::max(tip, (estimate.p_S_tip - truth.p_S_tip).norm());
    ASSERT_TRUE(estimate.force);
    force = std::max(force, (*estimate.force - truth.force).norm());
    const LocalModel local = sense_.LocalModelAt(p_S);
    const Vector3d by_plane = -local.stiffness * (truth.p_S_tip - local.reference);
    plane = std::max(plane, (by_plane - truth.force).norm());
    patch = std::max(patch, (ByPatch(p_S, site_.t) - truth.force).norm());
    EXPECT_LT((sense_.motion().offset - moved).norm(), kTolerance);
    const Vector3d off = sense_.motion().velocity - VelocityAt(site_.t - begin);
    square += off.squaredNorm() / std::pow(sense_.motion().velocity_error, 2);
  }
  EXPECT_GT(valid, 0.95 * images);
  EXPECT_LT(tip, kTolerance);
  EXPECT_LT(force, 0.04 * peak);
  EXPECT_LT(plane, 0.05 * peak);
  EXPECT_LT(patch, 0.07 * peak);  // a patch is valid up to an error of 1 % of its depth
  EXPECT_GT(std::sqrt(square / images), 0.5);
  EXPECT_LT(std::sqrt(square / images), 1.3);
}

// Also with a moving tool; the tolerance is the arm's delay.
TEST_F(MovingObjectTest, APressIntoAMovingObjectHasTheRightDepth) {
  const Vector3d home = scene_.manipulator.home;
  const Vector3d p_S_deep = Lower();
  const double peak = site_.truth().force.norm();
  Step(home, Vector3d::Zero());
  const double begin = site_.t;
  while (site_.t < begin + 2 * kDuration) {
    const double t = site_.t + 1 / kImageRate - begin;
    const double share = 0.5 - 0.5 * std::cos(2 * std::numbers::pi * t / 2.1);
    const ContactEstimate& estimate = Step(home + share * (p_S_deep - home), MotionAt(t));
    if (t < 0.5 || !estimate.force) continue;
    const Truth truth = site_.truth();
    EXPECT_LT((*estimate.force - truth.force).norm(), 0.05 * peak) << t;
    EXPECT_LT((estimate.p_S_tip - truth.p_S_tip).norm(), kTolerance) << t;
  }
}

// A tip that moves up and down by 20 mm, images with noise of a tenth of a pixel, and encoder
// readings that are one period old and have a scale error of 8 %.
class MotionOwnerTest : public testing::Test {
 protected:
  static constexpr double kPixel = 0.17e-3, kEncoderScale = 1.08;  // [m], [-]

  void Run(double seconds, const std::function<Vector3d(double)>& object,
           const std::function<Vector3d(double)>& camera) {
    for (const double end = t_ + seconds; t_ < end; t_ += 1 / kImageRate) {
      const auto tip = [](double t) { return Vector3d(0, 10e-3 * std::sin(2 * t), 0); };
      const auto noise = [this] { return Vector3d(spread_(random_), spread_(random_), 0); };
      ManipulatorAgreement::Sight sight;
      sight.at = At(t_);
      sight.p_S_seen = tip(t_) - camera(t_) + noise();
      sight.p_S_on_object = sight.p_S_seen - (object(t_) - camera(t_) + noise());
      sight.p_S_at_rest = sight.p_S_on_object;
      sight.sigma = sight.object_sigma = 0.1 * kPixel;
      sight.object_known = true;
      sight.pixel = kPixel;
      agreement_.Update(sight, {kEncoderScale * tip(t_ - 1 / kImageRate), 1.5});
    }
  }
  [[nodiscard]] bool IsObjects() const { return !agreement_.motion().offset.isZero(0); }
  static Vector3d Nothing(double /*t*/) { return Vector3d::Zero(); }

  ManipulatorAgreement agreement_;

 private:
  std::mt19937 random_{3};
  std::normal_distribution<> spread_{0, 0.1 * kPixel};
  double t_ = 0;
};

TEST_F(MotionOwnerTest, DistinguishesCameraBumpsFromObjectShifts) {
  const auto step = [](double /*t*/) { return Vector3d(0, 1.5e-3, 0); };
  Run(2, Nothing, Nothing);
  Run(20, Nothing, step);
  EXPECT_FALSE(IsObjects());
  agreement_.Reset();
  Run(2, Nothing, Nothing);
  Run(3, step, Nothing);
  EXPECT_TRUE(IsObjects());
  Run(20, step, Nothing);
  EXPECT_TRUE(IsObjects());
}

}  // namespace
}  // namespace palpate
