// A pressed block as a finer mesh has it, seen as a cloud on a part of its surface: the force that
// the coarse model tells is right, or doubted.
#include "slave/pipeline/organ/cloud_load.h"

#include <cmath>
#include <limits>
#include <random>
#include <stdexcept>

#include <gtest/gtest.h>

#include "slave/mechanics/fem/green/fem_green_model.h"

namespace palpate {
namespace {

using Eigen::Vector3d;

constexpr double kModulus = 1e4, kNu = 0.4, kNoise = 1e-4;  // [Pa], [m]
const Vector3d kSize(0.1, 0.1, 0.05);
const Vector3d kTop(0.045, 0.055, 0.05);

HeldNodes HeldBelow(const SolidMesh& mesh) {
  HeldNodes held;
  for (const auto& p : mesh.nodes) held.push_back({p.z() == 0, p.z() == 0, p.z() == 0});
  return held;
}

std::vector<std::array<int, 3>> TopOf(const SolidMesh& mesh) {
  std::vector<std::array<int, 3>> top;
  for (const auto& t : SurfaceOf(mesh).triangles) {
    const auto is_up = [&](int n) { return mesh.nodes[static_cast<std::size_t>(n)].z() > 0.0499; };
    if (is_up(t[0]) && is_up(t[1]) && is_up(t[2])) top.push_back(t);
  }
  return top;
}

struct Press {
  Vector3d p_O, force;
};

// Of the finer block's top, under discs of 16 mm.
std::vector<Vector3d> CloudUnder(const std::vector<Press>& presses, int count = 400,
                                 double outliers = 0) {
  static const SolidMesh mesh = MeshBox(kSize, {20, 20, 10});
  static const auto top = TopOf(mesh);
  static FemGreenModel model(mesh, HeldBelow(mesh), kModulus, kNu, {});
  std::vector<Vector3d> u(mesh.nodes.size(), Vector3d::Zero());
  if (!presses.empty()) {
    std::vector<Contact> contacts;
    for (const auto& press : presses) {
      contacts.push_back({.kind = Contact::Kind::kForce,
                          .p_O = press.p_O,
                          .width = 0.016,
                          .prescribed_O = press.force});
    }
    Solution solution;
    model.Solve(contacts, &solution);
    EXPECT_NE(solution.responses()[0].validity, Validity::kFailed);
    model.Displacements(solution, &u);
  }
  std::mt19937 random(7);
  std::uniform_real_distribution<double> share(0, 1);
  std::normal_distribution<double> noise(0, kNoise);
  std::vector<Vector3d> cloud;
  for (int i = 0; i < count; ++i) {
    const auto& t = top[static_cast<std::size_t>(share(random) * static_cast<double>(top.size()))];
    double a = share(random), b = share(random);
    if (a + b > 1) a = 1 - a, b = 1 - b;
    const double weights[] = {1 - a - b, a, b};
    Vector3d p(noise(random), noise(random), noise(random));
    for (std::size_t c = 0; c < 3; ++c) {
      const auto n = static_cast<std::size_t>(t[c]);
      p += weights[c] * (mesh.nodes[n] + u[n]);
    }
    if (share(random) < outliers) p.z() += 0.01 * share(random);
    cloud.push_back(p);
  }
  return cloud;
}

CloudLoad MakeLoad(double modulus = kModulus) {
  const SolidMesh mesh = MeshBox(kSize, {14, 14, 7});
  CloudLoad::Params params{.young_modulus = modulus, .poisson_ratio = kNu, .sigma = kNoise};
  params.seen = TopOf(mesh);
  return {mesh, HeldBelow(mesh), params};
}

// One, for the tests that leave it as it was.
CloudLoad& Load() {
  static CloudLoad load = MakeLoad();
  load.Reset();
  return load;
}

double Sigma(const CloudForce& told) {
  return std::sqrt(told.covariance_O.trace());
}

// Tolerance: two meshes of four nodes, 5 and 7 mm, differ by 2 to 6 % under such a disc.
void ExpectEstimate(const CloudForce& told, const Vector3d& force) {
  EXPECT_EQ(told.validity, Validity::kValid) << told.why;
  const double error = (told.force_O - force).norm();
  EXPECT_LT(error, 0.12 * force.norm()) << told.force_O.transpose();
  EXPECT_LT(error, 3 * Sigma(told)) << told.force_O.transpose();
  EXPECT_LT(Sigma(told), 0.15 * force.norm());
}

TEST(CloudLoadTest, ForceAndPlaceOfAPressThatNobodyPointedAt) {
  for (const Vector3d& force : {Vector3d(0, 0, -2), Vector3d(0.6, -0.4, -1.5)}) {
    const CloudForce told = Load().Fit(CloudUnder({{kTop, force}}));
    ExpectEstimate(told, force);
    EXPECT_LT((told.patch.p_O - kTop).norm(), 0.003) << told.patch.p_O.transpose();
  }
}

TEST(Long, OutliersCountForLittle) {
  const Vector3d force(0, 0, -2);
  const CloudForce told = Load().Fit(CloudUnder({{kTop, force}}, 400, 0.1));
  EXPECT_LT((told.force_O - force).norm(), 0.15 * force.norm()) << told.force_O.transpose();
}

TEST(Long, FollowsAForceThatGrowsAndWandersToAnotherPlace) {
  CloudLoad& load = Load();
  for (const double z : {-1.0, -1.2, -1.5, -2.0}) {
    ExpectEstimate(load.Fit(CloudUnder({{kTop, {0, 0, z}}})), {0, 0, z});
  }
  const Vector3d other(0.07, 0.03, 0.05);
  ExpectEstimate(load.Fit(CloudUnder({{other, {0, 0, -2}}})), {0, 0, -2});
}

// Reference: what the same patch under 0.1 N does to the cloud is as small as the noise.
TEST(CloudLoadTest, NothingPressesIsNoForce) {
  const CloudForce told = Load().Fit(CloudUnder({}));
  EXPECT_EQ(told.validity, Validity::kValid);
  EXPECT_LE(told.force_O.norm(), 3 * Sigma(told));
  EXPECT_GT(Sigma(told), 0.01);
  EXPECT_LT(Sigma(told), 0.6);
}

TEST(CloudLoadTest, AReleasedLoadIsGone) {
  CloudLoad& load = Load();
  ExpectEstimate(load.Fit(CloudUnder({{kTop, {0, 0, -2}}})), {0, 0, -2});
  for (int cloud = 0; cloud < 2; ++cloud) {
    const CloudForce told = load.Fit(CloudUnder({}));
    EXPECT_LE(told.force_O.norm(), 3 * Sigma(told)) << told.force_O.transpose();
  }
}

// Faint loads cost an interval that holds them, not a wrong figure.
TEST(Long, FaintLoadsLieInTheirInterval) {
  for (const double z : {-0.05, -0.1, -0.2, -0.4}) {
    const CloudForce told = Load().Fit(CloudUnder({{kTop, {0, 0, z}}}));
    const double error = (told.force_O - Vector3d(0, 0, z)).norm();
    EXPECT_TRUE(error < 3 * Sigma(told) || told.validity != Validity::kValid)
        << z << ": " << told.force_O.transpose() << " +- " << Sigma(told);
  }
}

TEST(Long, TwoLoadsAreToldAsTheirSumOrDoubted) {
  const Vector3d one(0, 0, -2), other(0, 0, -1.5);
  const CloudForce told =
      Load().Fit(CloudUnder({{{0.025, 0.03, 0.05}, one}, {{0.075, 0.07, 0.05}, other}}));
  const bool is_right = (told.force_O - one - other).norm() < 3 * Sigma(told);
  EXPECT_TRUE(is_right || told.validity != Validity::kValid) << told.force_O.transpose();
}

TEST(Long, ALoadOutOfSightIsRightOrDoubted) {
  const Vector3d force(-2, 0, 0);
  const CloudForce told = Load().Fit(CloudUnder({{{0.1, 0.05, 0.025}, force}}));
  const bool is_right = (told.force_O - force).norm() < 3 * Sigma(told);
  EXPECT_TRUE(is_right || told.validity != Validity::kValid) << told.force_O.transpose();
}

// Law: the shape tells force over modulus, so what the modulus is wrong by the force is wrong by.
TEST(Long, ForceScalesWithTheModulus) {
  const auto cloud = CloudUnder({{kTop, {0, 0, -2}}});
  CloudLoad stiff = MakeLoad(2 * kModulus);
  const Vector3d once = Load().Fit(cloud).force_O, twice = stiff.Fit(cloud).force_O;
  EXPECT_LT((twice - 2 * once).norm(), 0.02 * twice.norm());
}

TEST(CloudLoadTest, FewPointsOrNoneThatAreNumbersLoseIt) {
  std::vector<Vector3d> cloud = CloudUnder({{kTop, {0, 0, -2}}});
  for (std::size_t i = 10; i < cloud.size(); ++i) {
    cloud[i].setConstant(std::numeric_limits<double>::quiet_NaN());
  }
  EXPECT_EQ(Load().Fit(cloud).validity, Validity::kTrackingLost);
  EXPECT_EQ(Load().Fit({}).validity, Validity::kTrackingLost);
}

TEST(CloudLoadTest, ImpossibleParametersAreRefused) {
  const SolidMesh mesh = MeshBox(kSize, {2, 2, 1});
  const auto make = [&](CloudLoad::Params params) { CloudLoad(mesh, HeldBelow(mesh), params); };
  EXPECT_THROW(make({.young_modulus = 0, .poisson_ratio = 0.4}), std::invalid_argument);
  EXPECT_THROW(make({.young_modulus = 1, .poisson_ratio = 0.4, .sigma = 0}), std::invalid_argument);
  EXPECT_THROW(make({.young_modulus = 1, .poisson_ratio = 0.4, .seen = {{0, 1, 99}}}),
               std::invalid_argument);
}

}  // namespace
}  // namespace palpate
