// The model as its users see it: contacts, supports, histories, refusals, and scales.
#include "slave/mechanics/fem/fem_model.h"

#include <algorithm>
#include <cmath>
#include <numbers>

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include "slave/mechanics/fem/solid/solid_model.h"
#include "slave/mechanics/mesh_resolution.h"
#include "slave/mesh/index.h"
#include "tests/slave/mechanics/fem/solids.h"
#include "tests/support/allocation_count.h"
#include "tests/support/thrown.h"

namespace palpate {
namespace {

using contacts::Move;
using contacts::Push;
using Eigen::Vector3d;
using solids::Displacement;
using solids::Respond;

SolidMesh CubeOfFoam(int n = 4) {
  return MeshBox({0.06, 0.06, 0.06}, {n, n, n});
}
solids::Held FixedFloor(const SolidMesh& mesh) {
  return FixedWhere(mesh, [](const Vector3d& p) { return p.z() < 1e-9; });
}

// If a point at a tenth of a triangle's height above the floor is moved, the free node must move
// ten times as far.
TEST(FemModel, APointThatLiesMostlyOnASupportIsFlagged) {
  const SolidMesh mesh = CubeOfFoam();
  FemModel model(mesh, FixedFloor(mesh), solids::Linear(solids::Foam()));
  const Vector3d d(-1e-5, 0, 0);
  EXPECT_EQ(Respond(model, {Move({0.06, 0.032, 0.012}, d)}).front().validity, Validity::kValid);
  const auto low = Respond(model, {Move({0.06, 0.032, 0.0015}, d)}).front();
  EXPECT_EQ(low.validity, Validity::kExtrapolated);
  EXPECT_EQ(low.flag_reason, kOnSupport);
}

// Law: the linear law's force is proportional to the displacement, even if the requested residual
// is near the rounding error.
TEST(FemModel, AskingForMoreDigitsThanThereAreIsHarmless) {
  const SolidMesh mesh = CubeOfFoam();
  for (const Vector3d& place : {Vector3d(0.0232, 0.0111, 0.06), Vector3d(0.06, 0.031, 0.0422)}) {
    Vector3d per_size(0, 0, 0);
    for (const double residual : {1e-8, 1e-12, 1e-14}) {
      auto params = solids::Linear(solids::Foam());
      params.options.residual = residual;
      FemModel model(mesh, FixedFloor(mesh), params);
      for (const double size : {0.5, 0.9, 1.0, 1.01}) {
        const auto r =
            Respond(model, {Move(place, size * Vector3d(0.001, -0.002, -0.003))}).front();
        ASSERT_EQ(r.validity, Validity::kValid) << model.failure();
        if (per_size.isZero()) per_size = r.force_O / size;
        EXPECT_LT((r.force_O / size - per_size).norm(), 1e-8 * per_size.norm()) << residual;
      }
    }
  }
}

// Law: without supports balanced loads have an answer, free of rigid motion, and it does not
// depend on where the body lies; others are refused.
TEST(FemModel, AnUnsupportedBodyTakesBalancedLoadsOnly) {
  SolidMesh mesh = CubeOfFoam();
  for (auto& p : mesh.nodes) p += Vector3d(3, -2, 1);
  for (const bool linear : {true, false}) {
    FemModel model(mesh, solids::Held(mesh.nodes.size()),
                   linear ? solids::Linear(solids::Foam()) : solids::Foam());
    const Vector3d low(3.0, -1.97, 1.03), high(3.06, -1.97, 1.03);
    Solution solution;
    const auto r =
        Respond(model, {Push(low, {-0.2, 0, 0}, 0.03), Push(high, {0.2, 0, 0}, 0.03)}, &solution);
    ASSERT_NE(r[0].validity, Validity::kFailed) << model.failure();
    EXPECT_GT(r[1].displacement_O.x(), 1e-4);
    Vector3d mean = Vector3d::Zero();
    const auto u = Displacement(model, solution);
    double volume = 0;
    for (std::size_t e = 0; e < mesh.tets.size(); ++e) {
      const double V = SignedVolume(mesh, static_cast<int>(e));
      for (const int i : mesh.tets[e]) mean += V / 4 * u[Index(i)];
      volume += V;
    }
    EXPECT_LT(mean.norm() / volume, 1e-9 * r[1].displacement_O.norm());
    EXPECT_EQ(Respond(model, {Push(low, {1, 0, 0})}).front().validity, Validity::kFailed);
    EXPECT_THAT(std::string(model.failure()), testing::HasSubstr("balance"));
    EXPECT_EQ(Respond(model, {Push(low, {0, 1, 0}), Push(high, {0, -1, 0})})[0].validity,
              Validity::kFailed);  // a couple
  }
}

// Law: after Reset() the answer is that of a new model, bit by bit.
TEST(FemModel, ResetForgetsTheHistory) {
  const SolidMesh mesh = CubeOfFoam();
  for (const auto time : {FemOptions::Time::kStatic, FemOptions::Time::kDynamic}) {
    auto params = solids::Foam();
    params.options.time = time;
    FemModel used(mesh, FixedFloor(mesh), params), fresh(mesh, FixedFloor(mesh), params);
    const Contact first = Move({0.03, 0.03, 0.06}, {0, 0.01, -0.02}, 0.03);
    const Contact second = Push({0.06, 0.03, 0.03}, {-0.05, 0, 0});
    for (int i = 0; i < 3; ++i) Respond(used, {first});
    used.Reset();
    Solution of_used, of_fresh;
    EXPECT_EQ(Respond(used, {second}, &of_used).front().displacement_O,
              Respond(fresh, {second}, &of_fresh).front().displacement_O);
    EXPECT_EQ(solids::Difference(Displacement(used, of_used), Displacement(fresh, of_fresh)), 0);
  }
}

// A body oscillates so far that its factor becomes outdated and is replaced, part by part, several
// times. Reference: the same motion with every linear system solved to rounding; a residual of 1e-6
// changes the final displacement by up to 1e-4. No memory is allocated during the motion.
TEST(FemModel, SwingsTheSameWithFactorsThatAge) {
  const SolidMesh mesh = CubeOfFoam(6);
  const auto held = FixedWhere(mesh, [](const Vector3d& p) { return p.x() < 1e-9; });
  const auto swing = [&](double residual, double* max_iterations) {
    auto params = solids::Foam();
    params.options.time = FemOptions::Time::kDynamic;
    params.options.residual = residual;
    FemModel model(mesh, held, params);
    std::vector<Contact> contacts{Push({0.06, 0.03, 0.03}, Vector3d::Zero(), 0.02)};
    std::vector<ContactResponse> responses(1);
    model.Respond(contacts, responses);
    const long before = AllocationCount();
    for (int step = 1; step <= 120; ++step) {
      contacts[0].prescribed_O.z() = 1.5 * std::sin(2 * std::numbers::pi * step / 50);
      model.Respond(contacts, responses);
      EXPECT_LE(model.residual(), residual) << "step " << step;
      const double iterations = model.stepper()->last_solve().iterations;
      *max_iterations = std::max(*max_iterations, iterations);
    }
    EXPECT_EQ(AllocationCount(), before);
    return responses[0].displacement_O;
  };
  double iterations = 0, exact_iterations = 0;
  const Vector3d exact = swing(1e-12, &exact_iterations), swung = swing(1e-6, &iterations);
  EXPECT_GT(exact.norm(), 0.005) << "no large motion";
  EXPECT_LT((swung - exact).norm(), 1e-4 * exact.norm());
  EXPECT_LT(iterations, 40) << "a factor is older than it should be";
}

struct StopListener final : Progress {
  bool Report(std::string_view stage, double done) override {
    ++calls;
    EXPECT_LE(done, 1) << stage;
    if (stage == "finding the equilibrium") shares.push_back(done);
    return !stop;
  }
  std::vector<double> shares;
  int calls = 0;
  bool stop = false;
};

void ExpectThatItStopsAndGoesOn(DeformationModel& model, const Contact& contact,
                                StopListener* listener) {
  listener->stop = true;
  listener->calls = 0;
  Solution solution;
  EXPECT_EQ(Respond(model, {contact}, &solution).front().validity, Validity::kFailed);
  EXPECT_EQ(model.failure(), "interrupted");
  EXPECT_EQ(listener->calls, 1);
  for (const auto& u : Displacement(model, solution)) ASSERT_EQ(u, Vector3d(0, 0, 0));
  listener->stop = false;
  listener->shares.clear();
  EXPECT_NE(Respond(model, {contact}).front().validity, Validity::kFailed) << model.failure();
  EXPECT_GT(listener->calls, 1);
  EXPECT_TRUE(std::is_sorted(listener->shares.begin(), listener->shares.end()));
}

// Law: a long search reports its progress, stops on request, and may be started again. The factor
// alone takes longer than the tenth of a second without reports. Tested with iterations, and with a
// factor, whose own reports may replace those of the search.
TEST(FemModel, LongSearchesReportProgressAndStop) {
  const SolidMesh bar = MeshBox({1, 0.1, 0.1}, {64, 9, 9});
  const auto held = FixedWhere(bar, [](const Vector3d& p) { return p.x() < 1e-9; });
  auto params = solids::Foam();
  params.material.young_modulus = 1e5;
  params.options.residual = 1e-6;
  StopListener listener;
  FemModel model(bar, held, params, &listener);
  ExpectThatItStopsAndGoesOn(model, Push({1, 0.05, 0.05}, {0, 0, -0.05}, 0.05), &listener);
  EXPECT_FALSE(listener.shares.empty());
  for (const auto& [nu, cells] : {std::pair{0.3, 12}, {0.499, 6}}) {
    const SolidMesh mesh = MeshBox({1, 1, 1}, {cells, cells, cells});
    SolidModel::Params of_solid{.options = {.element = FemOptions::Element::kTet10,
                                            .law = FemOptions::Law::kNeoHookean,
                                            .residual = 1e-8},
                                .young_modulus = 3800,
                                .poisson_ratio = nu};
    StopListener of_search;
    SolidModel solid(mesh, FixedFloor(mesh), of_solid, &of_search);
    ExpectThatItStopsAndGoesOn(solid, Move({0.5, 0.5, 1}, {0.02, 0, -0.08}, 0.4), &of_search);
  }
}

// Law: if the cube is pressed flat and further, inverted elements are counted and the answer is
// flagged.
TEST(FemModel, InversionIsFlaggedAndRecoveredFrom) {
  const SolidMesh mesh = CubeOfFoam(3);
  FemModel model(mesh, FixedFloor(mesh), solids::Foam());
  const auto deep = Respond(model, {Push({0.02, 0.02, 0.06}, {0, 0, -3})}).front();
  EXPECT_EQ(deep.validity, Validity::kExtrapolated) << model.failure();
  EXPECT_GT(model.inverted(), 0);
  EXPECT_THAT(model.info().remark, testing::HasSubstr("inside out"));
  const auto back = Respond(model, {Push({0.02, 0.02, 0.06}, {0, 0, 0})}).front();
  EXPECT_LT(back.displacement_O.norm(), 1e-9) << model.failure();
  EXPECT_EQ(back.validity, Validity::kValid);
}

TEST(FemModel, RefusesInvalidParameters) {
  using P = FemModel::Params;
  const std::vector<std::pair<void (*)(SolidMesh*, P*), const char*>> mistakes{
      {[](SolidMesh*, P* p) { p->material.poisson_ratio = 0.5; }, "poisson_ratio = 0.5"},
      {[](SolidMesh*, P* p) { p->options.element = FemOptions::Element::kTet10; }, "tet10"},
      {[](SolidMesh*, P* p) { p->options.gravity_O.z() = -9.8, p->material.density = 0; },
       "density"},
      {[](SolidMesh*, P* p) { p->options.residual = 0; }, "residual"},
      {[](SolidMesh* m, P*) { std::swap(m->tets[4][0], m->tets[4][1]); },
       "tetrahedron 4: expected a volume > 0"},
      {[](SolidMesh* m, P*) { m->tets[2][1] = 99; }, "element 2 has a node"},
      {[](SolidMesh* m, P*) { m->nodes[3].x() = std::nan(""); }, "node 3"},
      {[](SolidMesh* m, P*) { m->tets.clear(); }, "no element"}};
  for (const auto& [change, word] : mistakes) {
    SolidMesh mesh = CubeOfFoam(1);
    auto params = solids::Foam();
    change(&mesh, &params);
    EXPECT_THAT(Thrown<std::invalid_argument>(
                    [&] { const FemModel model(mesh, solids::Held(mesh.nodes.size()), params); }),
                testing::HasSubstr(word));
  }
}

// Law: a node that belongs to no element does not matter; everything may be held.
TEST(FemModel, DanglingNodesAndFullSupportAreAccepted) {
  const SolidMesh mesh = CubeOfFoam(2);
  SolidMesh dangling = mesh;
  dangling.nodes.emplace_back(0.03, 0.03, 0.7);
  const Contact contact = Push({0.06, 0.06, 0.06}, {0, 0.01, -0.02});
  FemModel a(mesh, FixedFloor(mesh), solids::Foam()),
      b(dangling, FixedFloor(dangling), solids::Foam());
  const Vector3d ua = Respond(a, {contact}).front().displacement_O;
  const Vector3d ub = Respond(b, {contact}).front().displacement_O;
  EXPECT_LT((ua - ub).norm(), 1e-11 * ua.norm());
  FemModel rigid(mesh, solids::Held(mesh.nodes.size(), {true, true, true}), solids::Foam());
  EXPECT_EQ(Respond(rigid, {contact}).front().displacement_O, Vector3d::Zero());
}

}  // namespace
}  // namespace palpate
