// Tests the error that von Karman's plate and its modes cause in a force found from the dots of a
// rubber sheet, over place, depth and thickness. The true force comes from a neo-Hookean solid that
// shares nothing with the models.
#include <algorithm>
#include <cmath>
#include <memory>
#include <random>
#include <string>
#include <tuple>
#include <vector>

#include <gtest/gtest.h>

#include "slave/mechanics/plate/fit/load_fit.h"
#include "slave/mechanics/plate/plate_large_model.h"
#include "slave/pipeline/points/surface_estimator.h"
#include "slave/reference/membrane/pressed_membrane.h"
#include "slave/vision/dots/dot_layout.h"
#include "tests/slave/pipeline/points/membrane_scene.h"
#include "tests/support/allocation_count.h"

namespace palpate {
namespace {

using Eigen::Vector2d;
using Eigen::Vector3d;
using testing_fakes::kModulus;
using testing_fakes::kNu;
using testing_fakes::kRadius;
using testing_fakes::kToolWidth;

constexpr double kDotNoise = 20e-6;  // of a dot, per axis [m]: as the two cameras make them
constexpr double kDepthStep = 0.5e-3;

struct Place {
  double thickness = 0;  // [m]
  double radii = 0;
  double deepest = 5e-3;  // [m]
};

simulation::PressedMembrane TruthAt(const Place& place) {
  const Vector2d p_O = place.radii * kRadius * Vector2d(std::cos(0.4), std::sin(0.4));
  return {{kRadius, place.thickness}, {kModulus, kNu}, kToolWidth, p_O};
}

std::unique_ptr<LoadIdentifier> BodyOf(double thickness) {
  Scene scene = testing_fakes::MembraneScene("plate-large");
  scene.object.geometry = MembraneGeometry{kRadius, thickness};
  return MakeLoadIdentifier(scene);
}

// `scatter`: true noise of a dot per axis [m]. `stated`: its stated sigma [m].
std::vector<SurfacePoint> Dots(const simulation::MembranePress& press, double depth,
                               std::mt19937* random, double scatter = kDotNoise,
                               double stated = kDotNoise) {
  std::normal_distribution<double> noise(0, scatter);
  std::vector<SurfacePoint> points;
  for (const Vector2d& dot : DotPlaces(PointTracking{})) {
    const Vector3d rest(dot.x(), dot.y(), 0);
    const double z = noise(*random), y = noise(*random);  // in this order with every compiler
    const Vector3d off(noise(*random), y, z);
    points.push_back({.id = static_cast<int>(points.size()),
                      .seen = true,
                      .p_S_rest = rest,
                      .p_S = rest + DisplacementAt(press, dot, depth) + off,
                      .covariance = stated * stated * Eigen::Matrix3d::Identity()});
  }
  return points;
}

// Reference: the solid's force. The bound of a press is 5 % of the force, or 1 % of that at 5 mm. A
// larger error must be within two standard deviations, or flagged.
class MembraneLawAt : public testing::TestWithParam<Place> {};

TEST_P(MembraneLawAt, EveryStepIsWithinTheBoundOrTwoSigmaOrFlagged) {
  const Place& place = GetParam();
  std::mt19937 random(1);
  const auto body = BodyOf(place.thickness);
  simulation::PressedMembrane truth = TruthAt(place);
  for (double depth = kDepthStep; depth < place.deepest + 1e-9; depth += kDepthStep) {
    ASSERT_TRUE(truth.Deepen(depth));
  }
  const double at_5mm = -ForceAt(truth.press(), 5e-3);
  for (double depth = kDepthStep; depth < place.deepest + 1e-9; depth += kDepthStep) {
    const double force = -ForceAt(truth.press(), depth);
    const SurfaceLoad load = body->Fit(Dots(truth.press(), depth, &random));
    ASSERT_NE(load.validity, Validity::kFailed);
    const double error = std::abs(-load.force - force);
    const double bound = std::max(0.05 * force, 0.01 * at_5mm);
    if (load.validity == Validity::kValid) {
      EXPECT_LT(error, std::max(bound, 2 * load.sigma_force)) << depth;
    }
    if (place.thickness == 1e-3 && depth < 5.1e-3) {
      EXPECT_LT(error, bound) << depth;
      EXPECT_EQ(load.validity, Validity::kValid) << load.reason;
    }
  }
}

// Reference: the true noise of the dots, a quarter of the stated sigma and equal to it. The
// reported sigma is smaller if the dots fit the load's shape better, but no smaller than their
// number justifies: not below the value for a stated quarter.
TEST(PlateLoadIdentifier, SigmaFollowsTheScatterIfThereAreEnoughDots) {
  simulation::PressedMembrane truth = TruthAt({1e-3, 0.3});
  ASSERT_TRUE(truth.Deepen(1e-3));
  const auto sigma = [&](double scatter, double stated) {
    std::mt19937 random(1);
    return BodyOf(1e-3)->Fit(Dots(truth.press(), 1e-3, &random, scatter, stated)).sigma_force;
  };
  const double closer = sigma(kDotNoise, 4 * kDotNoise),
               as_given = sigma(4 * kDotNoise, 4 * kDotNoise);
  EXPECT_LT(closer, 0.85 * as_given);
  EXPECT_GT(closer, 1.5 * sigma(kDotNoise, kDotNoise));
}

std::string InWords(const testing::TestParamInfo<Place>& place) {
  const int um = static_cast<int>(std::lround(1e6 * place.param.thickness));
  return std::to_string(um) + "um_at_" + std::to_string(std::lround(10 * place.param.radii)) +
         "_tenths";
}

INSTANTIATE_TEST_SUITE_P(Quick, MembraneLawAt,
                         testing::Values(Place{1e-3, 0, 8e-3}, Place{1e-3, 0.5}), InWords);
INSTANTIATE_TEST_SUITE_P(Long, MembraneLawAt,
                         testing::Values(Place{1e-3, 0.3}, Place{1e-3, 0.7}, Place{0.5e-3, 0},
                                         Place{0.5e-3, 0.3}, Place{0.5e-3, 0.5}, Place{0.5e-3, 0.7},
                                         Place{2e-3, 0}, Place{2e-3, 0.3}, Place{2e-3, 0.5},
                                         Place{2e-3, 0.7}, Place{3.9e-3, 0}),
                         InWords);

// Reference: the whole fit in modes of order 20, from the same dots; a tenth of the bound is
// allowed. Modes of order 12 are off it by 3 and 5 % there.
TEST(MembraneLaw, AFewFineStepsEqualTheWholeFineFit) {
  std::mt19937 random(2);
  for (const auto& [thickness, radii] : {std::tuple(1e-3, 0.7), std::tuple(0.5e-3, 0.5)}) {
    const Place place{thickness, radii};
    simulation::PressedMembrane truth = TruthAt(place);
    for (double depth = 1e-3; depth < 4.5e-3; depth += 1e-3) ASSERT_TRUE(truth.Deepen(depth));
    const auto points = Dots(truth.press(), 4e-3, &random);
    std::vector<Vector2d> places;
    std::vector<double> displacements, sigmas(points.size(), kDotNoise);
    for (const SurfacePoint& point : points) {
      places.emplace_back(point.p_S_rest.head<2>());
      displacements.push_back(point.p_S.z() - point.p_S_rest.z());
    }
    std::vector<LoadFit> fits;
    for (const int order : {12, 20}) {
      PlateLargeModel plate({.radius = kRadius,
                             .thickness = thickness,
                             .young_modulus = kModulus,
                             .poisson_ratio = kNu,
                             .order = order});
      fits.push_back(LoadFitter(plate, {kToolWidth}).Fit(places, displacements, sigmas));
    }
    const SurfaceLoad load = BodyOf(thickness)->Fit(points);
    EXPECT_GT(std::abs(fits[0].force / fits[1].force - 1), 0.02);
    EXPECT_NEAR(load.force / fits[1].force, 1, 0.005);
    EXPECT_NEAR((load.p_O.head<2>() - fits[1].p_O).norm(), 0, 1e-4);
    EXPECT_NEAR(load.residual, fits[1].residual, 0.05);
  }
}

TEST(MembraneLaw, MoreModesAllocateNothing) {
  std::mt19937 random(3);
  simulation::PressedMembrane truth = TruthAt({1e-3, 0.7});
  for (double depth = 1e-3; depth < 4.5e-3; depth += 1e-3) ASSERT_TRUE(truth.Deepen(depth));
  const auto body = BodyOf(1e-3);
  const auto shallow = Dots(truth.press(), 0.5e-3, &random);
  const auto deep = Dots(truth.press(), 4e-3, &random);
  body->Fit(shallow);
  const auto before = AllocationCount();
  const SurfaceLoad load = body->Fit(deep);
  EXPECT_EQ(AllocationCount() - before, 0);
  EXPECT_EQ(load.validity, Validity::kValid);
}

}  // namespace
}  // namespace palpate
