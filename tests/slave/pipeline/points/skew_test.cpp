// Two cameras that do not look at the same instant, on a membrane that moves: each force is right
// or is not `valid`. `Long` ones run all rows.
#include <algorithm>
#include <cmath>
#include <cstdio>
#include <memory>
#include <numbers>
#include <optional>
#include <string>
#include <vector>

#include <gtest/gtest.h>

#include "slave/pipeline/points/points_sense.h"
#include "slave/scene/scene_loader.h"
#include "slave/site/points/stereo_site.h"
#include "tests/support/paths.h"

namespace palpate {
namespace {

constexpr double kDepth = 5e-3;  // of the press [m]
constexpr int kRest = 14;        // pairs before the tool comes
constexpr int kMoving = 60;      // pairs after
constexpr double kRight = 0.05;  // of the largest force
constexpr double kSigmas = 3;

// The shipped membrane pressed to kDepth and let go, to and fro; the right picture is taken `skew`
// after the left one [s].
class SkewedEyes final : public StereoSource {
 public:
  // `speed`: the tool's largest [m/s].
  SkewedEyes(StereoSite* site, const Scene& scene, double speed, double skew)
      : site_(site),
        home_(scene.manipulator.home),
        period_(1 / scene.sense.Find<StereoCameras>()->rate),
        turn_(speed / (0.5 * kDepth)),
        skew_(skew) {}

  std::optional<StereoPair> Next(const std::stop_token& /*stop*/) override {
    const double t = static_cast<double>(count_) * period_;
    StereoPair pair;
    // In the order of time: the membrane is not moved back.
    const auto take = [&](bool is_left) {
      site_->MoveTool(TipAt(t + (is_left ? 0 : skew_)));
      StereoPictures pictures = site_->TakePictures();
      (is_left ? pair.left : pair.right) = is_left ? pictures.left : pictures.right;
    };
    take(skew_ >= 0);
    site_->MoveTool(TipAt(t + skew_ / 2));
    truth_ = site_->truth();
    take(skew_ < 0);
    pair.sequence = ++count_;
    pair.sensed_at = Time{} + Seconds(t + skew_ / 2);
    return pair;
  }
  [[nodiscard]] std::string description() const override { return "skewed eyes"; }
  [[nodiscard]] const Truth& truth() const { return truth_; }  // at the pair's stamp

 private:
  [[nodiscard]] Eigen::Vector3d TipAt(double t) const {
    const double since = t - kRest * period_;
    const double depth = since > 0 ? 0.5 * kDepth * (1 - std::cos(turn_ * since)) : -1e-3;
    return {home_.x(), home_.y(), -depth};
  }

  StereoSite* site_;
  Eigen::Vector3d home_;
  double period_, turn_, skew_;
  std::uint64_t count_ = 0;
  Truth truth_;
};

struct Row {
  int valid = 0, silent = 0, other = 0;
  double rms = 0, worst = 0;  // of the valid ones, of the largest force
};

Row RunRow(StereoSite* site, const Scene& scene, double peak, double speed, double skew) {
  auto eyes = std::make_unique<SkewedEyes>(site, scene, speed, skew);
  const SkewedEyes& seen = *eyes;
  PointsSense sense(scene, std::move(eyes));
  Row row;
  for (int pair = 0; pair < kRest + kMoving && sense.Acquire({}); ++pair) {
    sense.Look();
    const ContactEstimate& felt = sense.Estimate(seen.truth().p_S_tip);
    if (pair < kRest) continue;
    if (felt.validity != Validity::kValid || !felt.force) {
      ++row.other;
      continue;
    }
    const double error = (*felt.force - seen.truth().force).norm() / peak;
    ++row.valid;
    row.rms += error * error;
    row.worst = std::max(row.worst, error);
    row.silent += !(error <= kRight || error <= kSigmas * felt.sigma / peak);
  }
  row.rms = std::sqrt(row.rms / std::max(1, row.valid));
  std::printf(
      "%3.0f mm/s, right picture %+6.1f ms: %2d of %d valid, rms %4.1f %%, worst %5.1f %%, "
      "%d silently wrong\n",
      1e3 * speed, 1e3 * skew, row.valid, row.valid + row.other, 100 * row.rms, 100 * row.worst,
      row.silent);
  return row;
}

// Reference: the simulated site's large-strain solid. Tolerance: the 5 % of the largest force that
// are promised of what is `valid`.
void ExpectRightOrNotValid(const std::vector<double>& speeds, const std::vector<double>& skews) {
  const Scene scene = LoadScene(SourcePath("/deploy/scenes/rubber-membrane.yaml"));
  StereoSite site(scene);
  site.SolveAhead();
  const Eigen::Vector3d home = scene.manipulator.home;
  site.MoveTool({home.x(), home.y(), -kDepth});
  const double peak = site.truth().force.norm();
  for (const double speed : speeds) {
    for (const double skew : skews) {
      const Row row = RunRow(&site, scene, peak, speed, skew);
      EXPECT_EQ(row.silent, 0) << speed << " " << skew;
      EXPECT_LE(row.rms, kRight) << speed << " " << skew;
      if (skew == 0) EXPECT_GE(row.valid, 0.8 * kMoving) << speed;
    }
  }
}

TEST(SkewTest, EyesApartAreRightOrNotValid) {
  ExpectRightOrNotValid({30e-3}, {0, 10e-3});
}

TEST(Long, EveryRow) {
  ExpectRightOrNotValid({5e-3, 15e-3, 30e-3, 60e-3},
                        {0, 1e-3, 2e-3, 5e-3, 10e-3, 20e-3, 40e-3, -5e-3, -20e-3, -40e-3});
}

}  // namespace
}  // namespace palpate
