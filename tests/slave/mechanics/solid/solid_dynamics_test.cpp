// Solids in time: frequencies and steps of implicit Euler.
#include <cmath>
#include <utility>
#include <vector>

#include <gtest/gtest.h>

#include "slave/mechanics/fem/solid/solid_model.h"
#include "tests/slave/mechanics/solid/bodies.h"

namespace palpate {
namespace {

using namespace solid_tests;  // NOLINT(google-build-using-namespace): its helpers are for here
using Eigen::Vector3d;

SolidModel::Params Rod() {
  return {.options = {.element = Element::kTet10,
                      .law = Law::kLinear,
                      .time = FemOptions::Time::kDynamic,
                      .step = 1e-4},
          .young_modulus = 3000,
          .poisson_ratio = 0,
          .density = 26,
          .range = 1};
}

// Reference: d_solid3d, rod_frequency: a fixed-free rod, f1 = c / (4 L) = 13.427 Hz at nu = 0.
// Under a suddenly applied weight along its axis its tip reaches the maximum after half a period.
// Steps of 1/745 period change the frequency by 2e-5, ten nodes at 10 cells by less than 1e-3.
TEST(Rod, SwingsAtItsFrequency) {
  const double L = 0.2, w = 0.02, f1 = std::sqrt(3000.0 / 26) / (4 * L);
  const SolidMesh mesh = MeshBox({L, w, w}, {10, 1, 1});
  const auto held = FixedWhere(mesh, [](const Vector3d& p) { return p.x() == 0; });
  auto params = Rod();
  // The weight acts along x from the start.
  params.options.gravity_O = {1, 0, 0};
  SolidModel model(mesh, held, params);
  const int tip = NodeAt(model, L, {L, 0, 0});
  // Swings between rest and twice the static answer; the first mode's maximum is half a period
  // on.
  double before = 0, here = 0, time = 0;
  for (int i = 0; i < 2000; ++i) {
    model.Respond({}, {});
    ASSERT_TRUE(model.failure().empty()) << model.failure();
    const double next = model.displacement(tip).x();
    time = (i + 1) * params.options.step;
    if (i > 100 && here > before && next <= here) break;
    before = here;
    here = next;
  }
  // Under a uniform pull the tip's displacement over time consists of two parabolas, whose maximum
  // is exactly at half the period of the first mode.
  EXPECT_NEAR((time - params.options.step) * 2 * f1, 1, 0.01);
}

// Reference: one step of implicit Euler is one linear system: (M + h^2 K) v1 = M v0 + h (f - K u0);
// on one node m, k as above.
TEST(ImplicitEuler, MovesOneNodeAsItsLinearSystemSays) {
  const SolidMesh mesh{{{0, 0, 0}, {1, 0, 0}, {0, 1, 0}, {0, 0, 1}}, {{0, 1, 2, 3}}};
  HeldNodes held(4, {true, true, true});
  held[3] = {true, true, false};
  for (const Law law : {Law::kLinear, Law::kCorotational, Law::kNeoHookean}) {
    auto params = Rod();
    params.options.element = Element::kTet4;
    params.options.law = law;
    params.options.step = 0.02;
    SolidModel model(mesh, held, params);
    const double m = 26.0 / 60, k = 3000.0 / 6, h = 0.02;
    const double force = 1e-6;  // small, so that all laws are linear
    std::vector<ContactResponse> responses(1);
    double u = 0, v = 0;
    for (int i = 0; i < 20; ++i) {
      model.Respond(std::vector{Push({0, 0, 1}, {0, 0, force})}, responses);
      v = (m * v + h * (force - k * u)) / (m + h * h * k);
      u += h * v;
      EXPECT_NEAR(responses[0].displacement_O.z() / u, 1, 1e-7) << i;
    }
  }
}

// Law: after a step that fails the body moves on as if that step had not been requested.
TEST(ImplicitEuler, AFailedStepLeavesTheMotionAsItWas) {
  constexpr double kEdge = 0.04;
  const SolidMesh mesh = MeshBox({kEdge, kEdge, kEdge}, {4, 4, 4});
  const Vector3d top(kEdge / 2, kEdge / 2, kEdge);
  for (const Law law : {Law::kOgden, Law::kNeoHookean, Law::kLinear}) {
    auto params = Rod();
    params.options.element = Element::kTet4;
    params.options.law = law;
    if (law == Law::kOgden) params.options.terms = kRubber;
    params.options.step = law == Law::kOgden ? 1e-3 : 0.01;
    params.poisson_ratio = 0.3;
    // Ogden's energy is infinite for inverted elements. With other laws nodes move farther than
    // accepted.
    const double most = 0.9e6 * params.young_modulus * kEdge * kEdge;
    const Contact bad =
        law == Law::kOgden ? Move(top, {0, 0, -kEdge / 2}, kEdge / 2) : Push(top, {0, 0, most});
    SolidModel interrupted(mesh, Bottom(mesh), params), steady(mesh, Bottom(mesh), params);
    for (int k = 1; k <= 6; ++k) {
      if (k == 4) {
        EXPECT_EQ(Answer(interrupted, bad).validity, Validity::kFailed);
      }
      const Contact press = law == Law::kOgden ? Move(top, {0, 0, -2e-4 * k}, kEdge / 2)
                                               : Push(top, {0, 0, -0.005 * k});
      const ContactResponse is = Answer(interrupted, press), should = Answer(steady, press);
      ASSERT_EQ(is.validity, should.validity) << k << ": " << interrupted.failure();
      EXPECT_LT((is.force_O - should.force_O).norm(), 1e-6 * should.force_O.norm()) << k;
      EXPECT_LT((is.displacement_O - should.displacement_O).norm(),
                1e-6 * should.displacement_O.norm())
          << k;
    }
  }
}

}  // namespace
}  // namespace palpate
