#include <cmath>
#include <random>
#include <string>
#include <utility>
#include <vector>

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include "shared/mesh/disc_patch.h"
#include "slave/mechanics/factory/make_model.h"
#include "slave/pipeline/load/load_identifier.h"
#include "slave/pipeline/points/surface_estimator.h"
#include "tests/support/allocation_count.h"

namespace palpate {
namespace {

using Eigen::Vector3d;

constexpr double kCubeSide = 0.04, kCubeModulus = 4000, kCubeToolWidth = 0.012, kCubeSigma = 2e-5;

// This name in place of a kind means `fem` with the neo-Hookean law.
const std::string kNeoHookean = "neo-hookean";

Scene IdentifiedCube(const std::string& kind, int cells, double poisson_ratio = 0.15) {
  Scene scene;
  scene.name = "cube";
  scene.object.geometry = BoxGeometry{Vector3d::Constant(kCubeSide), {cells, cells, cells}};
  scene.object.material.young_modulus = kCubeModulus;
  scene.object.material.poisson_ratio = poisson_ratio;
  scene.object.fixed = {Fixed{FixedPlane{2, 0}}};
  scene.tool = Tool{.width = kCubeToolWidth};
  scene.model.kind = kind == kNeoHookean ? "fem" : kind;
  if (kind == kNeoHookean) scene.model.fem.law = FemOptions::Law::kNeoHookean;
  scene.model.range = 0.2;
  return scene;
}

// Motion of a grid of points on two sides of the cube under a press, by a model and mesh of its
// own.
class MeasuredCube {
 public:
  explicit MeasuredCube(const Scene& scene, double sigma = kCubeSigma)
      : scene_(scene),
        sigma_(sigma),
        mesh_(MeshObject(scene_, std::nullopt)),
        surface_(SurfaceOf(std::get<SolidMesh>(mesh_))),
        model_(MakeModel(scene_, mesh_)) {}

  std::vector<SurfacePoint> Press(const Vector3d& p_O, const Vector3d& force,
                                  std::mt19937* random) {
    const Contact contact{
        .kind = Contact::Kind::kForce, .p_O = p_O, .width = kCubeToolWidth, .prescribed_O = force};
    Solution solution;
    model_->Reset();
    model_->Solve({&contact, 1}, &solution);
    EXPECT_NE(solution.responses()[0].validity, Validity::kFailed);
    std::vector<Vector3d> u;
    model_->Displacements(solution, &u);
    std::normal_distribution<double> noise(0, sigma_);
    std::vector<SurfacePoint> points;
    for (int i = 1; i < 6; ++i) {
      for (int j = 1; j < 6; ++j) {
        for (const bool top : {true, false}) {
          const double a = kCubeSide * i / 6, b = kCubeSide * j / 6;
          const Vector3d rest = top ? Vector3d(a, b, kCubeSide) : Vector3d(kCubeSide, a, b);
          const auto place = FindPlace(surface_, rest);
          const double z = noise(*random), y = noise(*random);  // in this order with every compiler
          Vector3d moved(noise(*random), y, z);
          for (std::size_t c = 0; c < 3; ++c) {
            const int node = surface_.triangles[static_cast<std::size_t>(place->triangle)][c];
            moved +=
                place->weights[static_cast<Eigen::Index>(c)] * u[static_cast<std::size_t>(node)];
          }
          points.push_back({static_cast<int>(points.size()), true, rest, rest + moved,
                            sigma_ * sigma_ * Eigen::Matrix3d::Identity()});
        }
      }
    }
    return points;
  }

 private:
  Scene scene_;
  double sigma_;  // of a point's coordinate [m]
  ObjectMesh mesh_;
  SurfaceMesh surface_;
  std::unique_ptr<DeformationModel> model_;
};

// The points need several observations to be computed.
SurfaceLoad Fitted(LoadIdentifier& identifier, const std::vector<SurfacePoint>& points) {
  SurfaceLoad load = identifier.Fit(points);
  for (int i = 0; i < 50 && load.validity == Validity::kFailed; ++i) load = identifier.Fit(points);
  return load;
}

// Reference: the load itself through the estimator's own co-rotational model, pressed 4 mm deep;
// small strain alone has an error of several percent. The remaining error comes from noise of 20
// um.
TEST(VolumeLoadIdentifier, RefinesTheLoadWhereTheModelIsNotLinear) {
  MeasuredCube truth(IdentifiedCube("fem", 6));
  std::mt19937 random(2);
  const Vector3d p(0.02, 0.02, kCubeSide);
  const auto points = truth.Press(p, {0, 0, -0.2}, &random);
  Scene linear = IdentifiedCube("fem", 6);
  linear.model.fem.law = FemOptions::Law::kLinear;
  const SurfaceLoad coarse = Fitted(*MakeLoadIdentifier(linear), points);
  const SurfaceLoad load = Fitted(*MakeLoadIdentifier(IdentifiedCube("fem", 6)), points);
  ASSERT_TRUE(IsForceKnown(load.validity)) << load.reason;
  EXPECT_NEAR(load.force / -0.2, 1, 0.01);
  EXPECT_NEAR((load.p_O - p).norm(), 0, 5e-4);
  EXPECT_GT(std::abs(coarse.force / -0.2 - 1), 0.02);
  EXPECT_LT(load.residual, 0.5 * coarse.residual);
}

// Reference: chi-square over 60 images through the same linear model; the mean of squares has a
// standard deviation of sqrt(2 / 60) = 0.18.
TEST(VolumeLoadIdentifier, SigmaIsTheForcesStandardDeviation) {
  MeasuredCube truth(IdentifiedCube("fem-green", 6));
  std::mt19937 random(3);
  const auto body = MakeLoadIdentifier(IdentifiedCube("fem-green", 6));
  double sum = 0;
  constexpr int kImages = 60;
  for (int i = 0; i < kImages; ++i) {
    const SurfaceLoad load =
        Fitted(*body, truth.Press({0.02, 0.02, kCubeSide}, {0, 0, -0.02}, &random));
    const double error = (load.force + 0.02) / load.sigma_force;
    sum += error * error;
  }
  EXPECT_GT(sum / kImages, 0.3);
  EXPECT_LT(sum / kImages, 1.8);
}

TEST(VolumeLoadIdentifier, LeavesOutWrongPointsAndFindsNoForceInNoise) {
  MeasuredCube truth(IdentifiedCube("fem-green", 6));
  std::mt19937 random(4);
  const auto body = MakeLoadIdentifier(IdentifiedCube("fem-green", 6));
  auto points = truth.Press({0.02, 0.02, kCubeSide}, {0, 0, -0.05}, &random);
  const double reference = Fitted(*body, points).force;
  points[7].p_S.z() += 1e-3;
  points[20].p_S.x() -= 2e-3;
  const SurfaceLoad load = Fitted(*body, points);
  EXPECT_EQ(load.validity, Validity::kValid) << load.reason;
  EXPECT_NEAR(load.force / reference, 1, 0.01);
  for (int i = 0; i < 20; ++i) {
    const SurfaceLoad nothing =
        Fitted(*body, truth.Press({0.02, 0.02, kCubeSide}, {0, 0, 0}, &random));
    EXPECT_EQ(nothing.validity, Validity::kValid);
    EXPECT_EQ(nothing.force, 0);
    EXPECT_GT(nothing.sigma_force, 0);
  }
  for (std::size_t i = 3; i < points.size(); ++i) points[i].seen = false;
  EXPECT_EQ(Fitted(*body, points).validity, Validity::kTrackingLost);
}

TEST(VolumeLoadIdentifier, FitsWithoutAllocatingOnceItKnowsThePoints) {
  MeasuredCube truth(IdentifiedCube("fem-green", 5));
  std::mt19937 random(6);
  const auto body = MakeLoadIdentifier(IdentifiedCube("fem-green", 5));
  const auto first = truth.Press({0.02, 0.02, kCubeSide}, {0, 0, -0.05}, &random);
  auto second = truth.Press({0.012, 0.02, kCubeSide}, {0, 0, -0.03}, &random);
  second[4].p_S.z() += 2e-3;
  second[9].seen = false;
  EXPECT_NE(Fitted(*body, first).force, 0);
  EXPECT_NE(Fitted(*body, second).force, 0);
  const long before = AllocationCount();
  EXPECT_NE(Fitted(*body, first).force, 0);
  EXPECT_NE(Fitted(*body, second).force, 0);
  EXPECT_TRUE(body->PressAt({0.02, 0.02, kCubeSide}, 1e-3).force > 0);
  EXPECT_EQ(AllocationCount(), before);
}

// Law: a force has the flags of the model's answer.
TEST(VolumeLoadIdentifier, AReasonOfTheModelFlagsTheForce) {
  for (const char* kind : {"fem-green", "fem"}) {
    const Scene scene = IdentifiedCube(kind, 6, 0.495);
    MeasuredCube truth(scene);
    std::mt19937 random(7);
    const SurfaceLoad load = Fitted(*MakeLoadIdentifier(scene),
                                    truth.Press({0.02, 0.02, kCubeSide}, {0, 0, -0.05}, &random));
    EXPECT_EQ(load.validity, Validity::kExtrapolated) << kind;
    EXPECT_THAT(std::string(load.reason), testing::HasSubstr("lock")) << kind;
  }
}

// Reference: the load itself on the same model, from 4 to about 11 mm deep on a cube of 40 mm. The
// tangent at rest has an error of tens of percent there. A flagged force may be wrong.
TEST(VolumeLoadIdentifier, AValidForceOfADeepPressIsWithinItsSigmas) {
  int valid = 0;
  for (const auto& [kind, sigma] :
       {std::pair{std::string("fem"), 1e-4}, {"fem", 5e-4}, {kNeoHookean, 1e-4}}) {
    const Scene scene = IdentifiedCube(kind, 6);
    MeasuredCube truth(scene, sigma);
    const auto identifier = MakeLoadIdentifier(scene);
    std::mt19937 random(8);
    for (const double force : {-0.2, -0.3, -0.4, -0.5, -0.6}) {
      if (kind == kNeoHookean && force < -0.3) continue;  // the cube collapses under 0.6 N
      const auto points = truth.Press({0.02, 0.02, kCubeSide}, {0, 0, force}, &random);
      const SurfaceLoad load = Fitted(*identifier, points);
      if (load.validity != Validity::kValid) continue;
      ++valid;
      EXPECT_LT(std::abs(load.force - force), 3.5 * load.sigma_force)
          << kind << ", " << force << " N at " << 1e6 * sigma << " um: " << load.force << " +- "
          << load.sigma_force << " N, " << 1e3 * load.depth << " mm deep";
    }
  }
  EXPECT_GE(valid, 8);
}

}  // namespace
}  // namespace palpate
