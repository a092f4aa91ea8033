#include "slave/vision/dots/stereo_dots.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <numbers>
#include <vector>

#include <gtest/gtest.h>

#include "slave/vision/dots/dot_layout.h"
#include "tests/slave/vision/dots/dot_images.h"
#include "tests/slave/vision/stereo/test_rigs.h"

namespace palpate {
namespace {

constexpr double kDotRadius = 0.002;  // of a dot [m]

// The membrane is a bump of `depth` [m] under `centre`, towards the cameras. Images and expected
// points come from this function; the images add only perspective.
struct Bump {
  Eigen::Vector2d centre{0, 0};
  double depth = 0;
  Eigen::Isometry3d X_SO = Eigen::Isometry3d::Identity();
  std::vector<int> hidden;

  [[nodiscard]] double Height(const Eigen::Vector2d& p) const {
    return -depth * std::exp(-(p - centre).squaredNorm() / (2 * 0.012 * 0.012));
  }
  [[nodiscard]] Eigen::Vector3d Place(const Eigen::Vector2d& p) const {
    return X_SO * Eigen::Vector3d(p.x(), p.y(), Height(p));
  }
  [[nodiscard]] Eigen::Vector3d Normal(const Eigen::Vector2d& p) const {
    const double h = Height(p) / (0.012 * 0.012);
    const Eigen::Vector2d slope = -h * (p - centre);
    return X_SO.linear() * Eigen::Vector3d(-slope.x(), -slope.y(), 1).normalized();
  }
};

const std::vector<Eigen::Vector2d>& Layout() {
  static const auto layout = LatticePlaces(31, {0.015, 0.010});
  return layout;
}

struct Pair {
  cv::Mat left, right;
};

Pair ImagesOf(const Bump& bump, std::uint64_t seed, double noise = 2, double fall = 0.15,
              double blur = 0.7) {
  std::vector<Eigen::Vector3d> places, normals;
  for (std::size_t k = 0; k < Layout().size(); ++k) {
    if (std::find(bump.hidden.begin(), bump.hidden.end(), static_cast<int>(k)) !=
        bump.hidden.end()) {
      continue;
    }
    places.push_back(bump.Place(Layout()[k]));
    normals.push_back(bump.Normal(Layout()[k]));
  }
  Pair pair;
  for (const int eye : {0, 1}) {
    DotImage image;
    image.noise = noise;
    image.blur = blur;
    image.light_fall = fall;
    image.dots = ArraySeen(eye, places, normals, kDotRadius);
    (eye == 0 ? pair.left : pair.right) = image.Render(2 * seed + static_cast<std::uint64_t>(eye));
  }
  return pair;
}

// Frame S equals frame O.
StereoDots::Params Params() {
  StereoDots::Params params;
  params.rig = VergedRig(SceneLens());
  params.X_SL = VergedPose(-1);
  params.layout = Layout();
  params.dot_radius = kDotRadius;
  params.rest_images = 3;
  return params;
}

void Rest(StereoDots* stereo, const Bump& bump = {}) {
  for (std::uint64_t k = 0; k < 3; ++k) {
    const Pair pair = ImagesOf(bump, 100 + k);
    stereo->Observe(pair.left, pair.right);
  }
  ASSERT_TRUE(stereo->at_rest_known());
}

// Largest error of the seen dots' displacements [m].
double Worst(const SurfaceObservation& seen, const Bump& bump) {
  const Bump rest;
  double worst = 0;
  for (std::size_t k = 0; k < Layout().size(); ++k) {
    if (!seen.points[k].seen) continue;
    const Eigen::Vector3d moved = bump.Place(Layout()[k]) - rest.Place(Layout()[k]);
    worst = std::max(worst, (seen.points[k].p_S - seen.points[k].p_S_rest - moved).norm());
  }
  return worst;
}

int CountSeen(const SurfaceObservation& observation) {
  return static_cast<int>(std::count_if(observation.points.begin(), observation.points.end(),
                                        [](const SurfacePoint& point) { return point.seen; }));
}

// Reference: the bump drawn. A pixel of disparity is 1.3 mm at 250 mm. The centroids' noise of
// 0.009 px in both cameras and in a rest frame of three pairs makes 0.02 mm; four times that for
// the worst of 341 points.
TEST(StereoDots, MeasuresTheMotionOfEveryDot) {
  StereoDots stereo(Params());
  Rest(&stereo);
  double worst = 0;
  for (int step = 0; step <= 10; ++step) {
    Bump bump;
    bump.depth = 0.0005 * step;
    bump.centre = {0.006, -0.004};
    const Pair pair = ImagesOf(bump, static_cast<std::uint64_t>(step));
    const SurfaceObservation& seen = stereo.Observe(pair.left, pair.right);
    ASSERT_TRUE(seen.found);
    EXPECT_EQ(CountSeen(seen), 31) << step;
    worst = std::max(worst, Worst(seen, bump));
  }
  EXPECT_LT(worst, 0.09e-3);
}

// Reference: the drawn positions. Without correction of the tilt, the depths would have an error
// from the difference of the biases in both cameras. Dots of 4 mm radius on a surface tilted by 40
// degrees show it.
TEST(StereoDots, TiltOfTheDotsDoesNotPullThem) {
  Bump bump;
  bump.X_SO.linear() = Eigen::AngleAxisd(0.7, Eigen::Vector3d::UnitY()).toRotationMatrix();
  StereoDots::Params params = Params();
  params.rest_images = 1;
  params.X_SO = bump.X_SO;
  const Pair pair = ImagesOf(bump, 1, 0, 0);
  const auto depth_error = [&](double radius) {
    params.dot_radius = radius;
    StereoDots stereo(params);
    const SurfaceObservation& seen = stereo.Observe(pair.left, pair.right);
    EXPECT_EQ(CountSeen(seen), 31);
    double sum = 0;
    for (std::size_t k = 0; k < Layout().size(); ++k) {
      sum += (seen.points[k].p_S - bump.Place(Layout()[k])).norm() / 31;
    }
    return sum;
  };
  const double corrected = depth_error(kDotRadius), uncorrected = depth_error(0);
  EXPECT_LT(corrected, 8e-6);
  EXPECT_LT(corrected, 0.7 * uncorrected);
}

// Two cameras 60 degrees apart see each dot under different tilts. Reference: the drawn positions.
// Tolerance: 0.01 px for rounding of a centroid; uncorrected, or with the normal of the other
// camera, the mean error is 0.05 px.
TEST(StereoDots, EachCameraSeesADotsTiltInItsOwnFrame) {
  const auto looking = [](double turn) {
    Eigen::Isometry3d X_OC = Eigen::Isometry3d::Identity();
    X_OC.linear() = Eigen::AngleAxisd(turn, Eigen::Vector3d::UnitY()).toRotationMatrix();
    X_OC.translation() = -0.25 * X_OC.linear().col(2);
    return X_OC;
  };
  const std::array<Eigen::Isometry3d, 2> X_OC{looking(std::numbers::pi / 6),
                                              looking(-std::numbers::pi / 6)};
  StereoDots::Params params = Params();
  params.rig.X_RL = X_OC[1].inverse() * X_OC[0];
  params.X_SL = X_OC[0];
  params.rest_images = 1;
  std::array<DotImage, 2> images;
  for (std::size_t eye = 0; eye < 2; ++eye) {
    images[eye].noise = 0;
    const Eigen::Isometry3d X_CO = X_OC[eye].inverse();
    for (const Eigen::Vector2d& p : Layout()) {
      images[eye].dots.push_back(DiscSeen(params.rig.left, X_CO * Eigen::Vector3d(p.x(), p.y(), 0),
                                          X_CO.linear().col(2), kDotRadius));
    }
  }
  StereoDots stereo(params);
  const SurfaceObservation& seen = stereo.Observe(images[0].Render(), images[1].Render());
  ASSERT_EQ(CountSeen(seen), 31);
  Eigen::Vector3d mean = Eigen::Vector3d::Zero();
  for (std::size_t k = 0; k < Layout().size(); ++k) {
    mean += (seen.points[k].p_S - Bump{}.Place(Layout()[k])) / 31;
  }
  EXPECT_LT(mean.norm(), 0.01 * 0.25 / 800);
}

// Reference: the errors over 40 pairs against the covariances stated with the noise's own sigma.
TEST(StereoDots, ErrorsAreAsLargeAsTheCovariancesSay) {
  StereoDots::Params params = Params();
  params.sigma_px = 0;
  params.rest_images = 1;
  StereoDots stereo(params);
  const Bump bump;
  double mahalanobis = 0;
  int count = 0;
  for (std::uint64_t seed = 1; seed <= 40; ++seed) {
    const Pair pair = ImagesOf(bump, seed, 2, 0);
    const SurfaceObservation& seen = stereo.Observe(pair.left, pair.right);
    for (std::size_t k = 0; k < Layout().size(); ++k) {
      const Eigen::Vector3d error = seen.points[k].p_S - bump.Place(Layout()[k]);
      mahalanobis += error.dot(seen.points[k].covariance.inverse() * error) / 3;
      ++count;
    }
  }
  EXPECT_LT(mahalanobis / count, 1.2);
  EXPECT_GT(mahalanobis / count, 0.2);
}

TEST(StereoDots, DotsThatLeaveComeBackAsThemselves) {
  StereoDots stereo(Params());
  Rest(&stereo);
  for (int step = 0; step < 40; ++step) {
    Bump bump;
    bump.depth = 0.004 * std::sin(0.2 * step) * std::sin(0.2 * step);
    bump.X_SO.translation() << 0.0005 * step, 0.0003 * step, 0.0002 * step;
    if (step >= 10 && step < 30) bump.hidden = {0, 7, 8, 13, 30};
    const Pair pair = ImagesOf(bump, static_cast<std::uint64_t>(step));
    const SurfaceObservation& seen = stereo.Observe(pair.left, pair.right);
    ASSERT_TRUE(seen.found) << step;
    EXPECT_EQ(CountSeen(seen), 31 - static_cast<int>(bump.hidden.size())) << step;
    for (const int k : bump.hidden) EXPECT_FALSE(seen.points[static_cast<std::size_t>(k)].seen);
    EXPECT_LT(Worst(seen, bump), 0.12e-3) << step;
  }
}

// A jump of exactly one column: 48 px, at which every dot but the last column's falls on another.
TEST(StereoDots, JumpOfOneColumnIsNotTakenForStandingStill) {
  StereoDots stereo(Params());
  Rest(&stereo);
  Bump bump;
  bump.X_SO.translation() << 0.015, 0, 0;
  const Pair pair = ImagesOf(bump, 3);
  const SurfaceObservation& seen = stereo.Observe(pair.left, pair.right);
  ASSERT_TRUE(seen.found);
  EXPECT_EQ(CountSeen(seen), 31);
  EXPECT_LT(Worst(seen, bump), 0.1e-3);
}

}  // namespace
}  // namespace palpate
