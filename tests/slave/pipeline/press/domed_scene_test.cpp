// A scene's domed membrane under a depth camera inside of it, from images to the force.
#include <algorithm>
#include <array>
#include <cmath>
#include <deque>
#include <limits>
#include <memory>
#include <random>
#include <vector>

#include <gtest/gtest.h>

#include "slave/mechanics/membrane/inflated_membrane.h"
#include "slave/pipeline/points/points_sense.h"
#include "tests/slave/pipeline/given_images.h"
#include "tests/slave/pipeline/press/pressed_dome.h"
#include "tests/slave/vision/depth/depth_images.h"

namespace palpate {
namespace {

using Eigen::Vector2d;
using Eigen::Vector3d;

const Vector3d kAxes(0.06, 0.045, 0.05);
const Vector3d p_S_O(0.002, -0.003, 0.06);  // the rim's centre
constexpr double kInflation = 0.04, kDomeModulus = 1200, kDomeTension = 300, kAir = 8e-4,
                 kTool = 0.014;

Scene DomedScene() {
  Scene scene;
  scene.object.geometry = DomeGeometry{kAxes, kInflation, 0.5e-3, kAir};
  scene.object.X_SO.translation() = p_S_O;
  scene.object.material = {.young_modulus = kDomeModulus / 0.5e-3, .poisson_ratio = 0.5};
  scene.tool = Tool{.width = kTool};
  scene.model.kind = "membrane";
  scene.model.prestress = kDomeTension;
  PointsOptions points;
  points.cameras = TestDepthCamera();
  points.points.track = PointTracking::Track::kSurface;
  scene.sense.Set(points);
  return scene;
}

// A membrane with four times as many triangles as the scene's model. The pressure is even on a disc
// and decreases to 0 at its edge.
class DomeTruth {
 public:
  DomeTruth()
      : membrane_(Shape(), Params()), u_(membrane_.surface().nodes.size(), Vector3d::Zero()) {}

  void Press(const std::vector<Pressure>& pressures) {
    u_ = DisplacementsUnder(pressures, kTool, membrane_);
  }
  // Returns the surface point above x, y of O.
  [[nodiscard]] Vector3d Over(double x, double y) const {
    const double z = std::sqrt(1 - Vector2d(x / kAxes.x(), y / kAxes.y()).squaredNorm());
    return {x, y, kInflation - kAxes.z() + kAxes.z() * z};
  }
  // Returns the depth image of the camera at S's origin, with noise of 0.05 mm that is equal within
  // patches of 4 px.
  cv::Mat Image(std::mt19937* random) const {
    const DepthImages camera = TestDepthCamera();
    std::vector<double> inverse(320 * 240, 0);
    const auto& mesh = membrane_.surface();
    for (const auto& triangle : mesh.triangles) {
      std::array<Vector3d, 3> p;
      for (std::size_t k = 0; k < 3; ++k) {
        const auto node = static_cast<std::size_t>(triangle[k]);
        p[k] = p_S_O + mesh.nodes[node] + u_[node];
      }
      Draw(p, camera, &inverse);
    }
    return DepthImage(
        camera,
        [&](double x, double y) {
          const auto u = static_cast<std::size_t>(std::lround(camera.fx * x + camera.cx));
          const auto v = static_cast<std::size_t>(std::lround(camera.fy * y + camera.cy));
          const double one_over = inverse[320 * v + u];
          return one_over > 0 ? 1 / one_over : std::numeric_limits<double>::quiet_NaN();
        },
        {0.05e-3, 4}, random);
  }

 private:
  static MembraneShape Shape() {
    Ellipsoid ellipsoid;
    ellipsoid.semi_axes = kAxes.asDiagonal();
    ellipsoid.centre.z() = kInflation - kAxes.z();
    return MeshDomedMembrane(ellipsoid, Vector3d::UnitZ(), 0, 32);
  }
  static InflatedMembrane::Params Params() {
    InflatedMembrane::Params params{.modulus = kDomeModulus, .tension = kDomeTension};
    params.air_stiffness = (101'325 + InflatedMembrane(Shape(), params).pressure()) / kAir;
    return params;
  }
  // The inverse of the depth is linear over the pixels of a triangle.
  static void Draw(const std::array<Vector3d, 3>& p, const DepthImages& camera,
                   std::vector<double>* inverse) {
    Eigen::Matrix3d corners;  // columns: pixel, 1
    Vector3d depths;
    for (int k = 0; k < 3; ++k) {
      const Vector3d& q = p[static_cast<std::size_t>(k)];
      corners.col(k) << camera.fx * q.x() / q.z() + camera.cx,
          camera.fy * q.y() / q.z() + camera.cy, 1;
      depths[k] = 1 / q.z();
    }
    const Eigen::Matrix3d shares = corners.inverse();
    if (!shares.allFinite()) return;
    const Vector3d low = corners.rowwise().minCoeff(), high = corners.rowwise().maxCoeff();
    for (int v = std::max(0, static_cast<int>(low.y())); v <= std::min(239.0, high.y()); ++v) {
      for (int u = std::max(0, static_cast<int>(low.x())); u <= std::min(319.0, high.x()); ++u) {
        const Vector3d share = shares * Vector3d(u, v, 1);
        if (share.minCoeff() < -1e-9) continue;
        (*inverse)[static_cast<std::size_t>(320 * v + u)] = share.dot(depths);
      }
    }
  }

  InflatedMembrane membrane_;
  std::vector<Vector3d> u_;
};

class DomedSceneTest : public ::testing::Test {
 protected:
  explicit DomedSceneTest(const Scene& scene = DomedScene())
      : sense_(scene, std::make_unique<GivenImages>(images_)) {
    for (int i = 0; i < 5; ++i) Estimate({});
  }
  const ContactEstimate& Estimate(const std::vector<Pressure>& pressures) {
    truth_.Press(pressures);
    images_->push_back(truth_.Image(&random_));
    EXPECT_TRUE(sense_.Acquire({}));
    sense_.Process();
    return sense_.Estimate({p_S_O + Vector3d(0, 0, 2 * kInflation), std::nullopt});
  }

  DomeTruth truth_;
  std::mt19937 random_{3};
  std::shared_ptr<std::deque<cv::Mat>> images_ = std::make_shared<std::deque<cv::Mat>>();
  PointsSense sense_;
};

// Reference: the force on a membrane of finer triangles. Tolerance: 3 % for triangles of a third of
// the tool, plus three sigma; for the position a fifth of the tool.
TEST_F(DomedSceneTest, APressIsEstimatedAnywhere) {
  for (const Vector2d& at : {Vector2d(0, 0), Vector2d(-0.02, 0.01), Vector2d(0.025, -0.012)}) {
    const Vector3d p_O = truth_.Over(at.x(), at.y());
    for (const double force : {0.5, 2.0, 4.0}) {
      const ContactEstimate& estimate = Estimate({{p_O, force}});
      ASSERT_TRUE(estimate.force);
      EXPECT_EQ(estimate.validity, Validity::kValid) << sense_.why();
      EXPECT_NEAR(estimate.force->norm(), force, 0.03 * force + 3 * estimate.sigma)
          << at.transpose();
      EXPECT_GT(estimate.force->z(), 0);  // the skin pushes the tool out
      EXPECT_LT((estimate.p_S_contact - p_S_O - p_O).norm(), kTool / 5);
      EXPECT_LT(estimate.sigma, 0.15 * force);
    }
  }
}

// If a tool presses while the rest frame is taken, only the additional press is estimated, and
// nothing shows the error until the tool leaves. The surface that then bulges outwards must not be
// reported as a load.
TEST_F(DomedSceneTest, AnOutwardMotionOfTheSurfaceIsNoLoad) {
  for (const double force : {0.5, 1.5, 3.0}) {
    sense_.Reset([] { return true; });
    for (int i = 0; i < 5; ++i) Estimate({{truth_.Over(-0.02, 0.01), force}});
    const ContactEstimate& estimate = Estimate({});
    EXPECT_NE(estimate.validity, Validity::kValid) << force;
    EXPECT_EQ(estimate.check, FailedCheck::kRestShape) << force;
  }
}

TEST_F(DomedSceneTest, TwoToolsAreNotReportedAsOneForce) {
  const ContactEstimate& estimate =
      Estimate({{truth_.Over(-0.025, 0), 3}, {truth_.Over(0.025, 0.005), 3}});
  EXPECT_NE(estimate.validity, Validity::kValid);
  EXPECT_EQ(estimate.check, FailedCheck::kMisfit);
}

// Factor of the dome's height [-], displacement along x, and along z [m].
using Change = std::array<double, 3>;

Scene Changed(const Change& change) {
  Scene scene = DomedScene();
  std::get<DomeGeometry>(scene.object.geometry).inflation *= change[0];
  scene.object.X_SO.translation() += Vector3d(change[1], 0, change[2]);
  return scene;
}

class OtherDomeTest : public DomedSceneTest, public ::testing::WithParamInterface<Change> {
 protected:
  OtherDomeTest() : DomedSceneTest(Changed(GetParam())) {}
};

// A fifth higher or lower, or moved by a seventh of its height.
TEST_P(OtherDomeTest, IsNotTakenForTheScenes) {
  const ContactEstimate& estimate = Estimate({{truth_.Over(0, 0), 3}});
  EXPECT_NE(estimate.validity, Validity::kValid);
  EXPECT_EQ(estimate.check, FailedCheck::kRestShape);
}
INSTANTIATE_TEST_SUITE_P(Shapes, OtherDomeTest,
                         ::testing::Values(Change{1.2, 0, 0}, Change{0.8, 0, 0}, Change{1, 0, 6e-3},
                                           Change{1, 8e-3, 0}));

}  // namespace
}  // namespace palpate
