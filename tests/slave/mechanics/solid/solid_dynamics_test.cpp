// Solids in time: integrators, frequencies, energy.
#include <cmath>
#include <vector>

#include <gtest/gtest.h>

#include "slave/mechanics/fem/solid/solid_model.h"
#include "tests/slave/mechanics/solid/bodies.h"

namespace palpate {
namespace {

using namespace solid_tests;  // NOLINT(google-build-using-namespace): its helpers are for here
using Eigen::Vector3d;
using Integrator = FemOptions::Integrator;

SolidModel::Params Rod(Integrator integrator) {
  SolidModel::Params params;
  params.options.element = Element::kTet10;
  params.options.law = Law::kLinear;
  params.options.time = Time::kDynamic;
  params.options.integrator = integrator;
  params.options.step = 1e-4;
  params.young_modulus = 3000;
  params.poisson_ratio = 0;
  params.density = 26;
  params.range = 1;
  return params;
}

// Reference: d_solid3d, rod_frequency: a fixed-free rod, f1 = c / (4 L) = 13.427 Hz at nu = 0. Let
// go from its first mode's near shape (a uniform pull), it passes rest after a quarter period.
// Steps of 1/745 period change the frequency by 6e-6 (Newmark), ten nodes at 10 cells by less than
// 1e-3.
TEST(Rod, SwingsAtItsFrequency) {
  const double L = 0.2, w = 0.02, f1 = std::sqrt(3000.0 / 26) / (4 * L);
  const SolidMesh mesh = MeshBox({L, w, w}, {10, 1, 1});
  const auto held = HeldWhere(mesh, [](const Vector3d& p) { return p.x() == 0; });
  for (const auto mass : {FemOptions::Mass::kConsistent, FemOptions::Mass::kLumped}) {
    auto params = Rod(Integrator::kNewmark);
    params.options.mass = mass;
    // A body force at the mode's period excites it alone to first order: weight along x, kept on.
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
    // A uniform pull on a rod makes a tip that moves as two parabolas: its top is at half the
    // period of the first mode, exactly.
    EXPECT_NEAR((time - params.options.step) * 2 * f1, 1, 0.01);
  }
}

// Reference: d_solid3d, integrators_sdof: amplitude factors per step of one oscillator, from the
// energy that is left: implicit Euler (1 + (omega h)^2)^(-1/2), Newmark's average acceleration 1.
// One free node makes three equal oscillators: omega is measured by the static answer.
TEST(Integrators, KeepOrLoseTheAmplitudeTheyMust) {
  const SolidMesh mesh{{{0, 0, 0}, {1, 0, 0}, {0, 1, 0}, {0, 0, 1}}, {{0, 1, 2, 3}}};
  HeldNodes held(4, {true, true, true});
  held[3] = {true, true, false};
  for (const Integrator integrator : {Integrator::kImplicitEuler, Integrator::kNewmark}) {
    auto params = Rod(integrator);
    params.options.element = Element::kTet4;
    params.options.mass = FemOptions::Mass::kLumped;
    params.options.step = 0.01;
    SolidModel model(mesh, held, params);
    // m = rho V / 4, k = E V (dN/dz)^2 with nu = 0.
    const double m = 26.0 / 24, k = 3000.0 / 6, x = k / m * 1e-4;
    const double factor = integrator == Integrator::kNewmark ? 1 : 1 / (1 + x);
    std::vector<ContactResponse> responses(1);
    const std::vector<Contact> kick{Push({0, 0, 1}, {0, 0, 5})};
    for (int i = 0; i < 3; ++i) model.Respond(kick, responses);
    model.Respond({}, {});
    double energy = model.energy();
    for (int i = 0; i < 50; ++i) {
      model.Respond({}, {});
      // Newmark's energy is that of the midpoints' motion, kept exactly by the linear law; implicit
      // Euler's falls by the square of the amplitude's factor.
      EXPECT_NEAR(model.energy() / energy, factor, 1e-9);
      energy = model.energy();
    }
  }
}

// Reference: one step of implicit Euler is one linear system: (M + h D + h^2 K) v1 = M v0 + h (f -
// K u0), D = a M + b K; on one node m, k as above.
TEST(Integrators, DampAsRayleighSays) {
  const SolidMesh mesh{{{0, 0, 0}, {1, 0, 0}, {0, 1, 0}, {0, 0, 1}}, {{0, 1, 2, 3}}};
  HeldNodes held(4, {true, true, true});
  held[3] = {true, true, false};
  for (const Law law : {Law::kLinear, Law::kCorotational, Law::kNeoHookean}) {
    auto params = Rod(Integrator::kImplicitEuler);
    params.options.element = Element::kTet4;
    params.options.law = law;
    params.options.mass = FemOptions::Mass::kLumped;
    params.options.step = 0.02;
    params.options.damping_mass = 1;
    params.options.damping_stiffness = 0.01;
    SolidModel model(mesh, held, params);
    const double m = 26.0 / 24, k = 3000.0 / 6, h = 0.02, d = 1 * m + 0.01 * k;
    const double force = 1e-6;  // small, so that all laws are linear
    std::vector<ContactResponse> responses(1);
    double u = 0, v = 0;
    for (int i = 0; i < 20; ++i) {
      model.Respond(std::vector{Push({0, 0, 1}, {0, 0, force})}, responses);
      v = (m * v + h * (force - k * u)) / (m + h * d + h * h * k);
      u += h * v;
      EXPECT_NEAR(responses[0].displacement_O.z() / u, 1, 1e-7) << i;
    }
  }
}

// Undriven, the energy never grows with implicit Euler iterated to its residual: every step of the
// convex energies here is a minimum. Large motion, released from a load that turns the bar.
TEST(Energy, NeverGrowsWithImplicitEulerIteratedToItsResidual) {
  const SolidMesh mesh = MeshBox({0.2, 0.02, 0.02}, {10, 1, 1});
  const auto held = HeldWhere(mesh, [](const Vector3d& p) { return p.x() == 0; });
  for (const Law law : {Law::kCorotational, Law::kNeoHookean}) {
    for (const double step : {1e-3, 0.02}) {
      auto params = Rod(Integrator::kImplicitEuler);
      params.options.element = Element::kTet4;
      params.options.law = law;
      params.options.newton = 0;
      params.options.residual = 1e-10;
      params.options.step = step;
      params.poisson_ratio = 0.3;
      SolidModel model(mesh, held, params);
      std::vector<ContactResponse> responses(1);
      for (int i = 0; i < 10; ++i) {
        model.Respond(std::vector{Push({0.2, 0.02, 0.02}, {0, 0, 0.02})}, responses);
        ASSERT_TRUE(IsForceKnown(responses[0].validity)) << model.failure();  // of one node
      }
      double energy = model.energy();
      EXPECT_GT(energy, 0);
      for (int i = 0; i < 60; ++i) {
        model.Respond({}, {});
        ASSERT_TRUE(model.failure().empty()) << model.failure();
        EXPECT_LE(model.energy(), energy * (1 + 1e-9)) << "step " << i;
        energy = model.energy();
      }
    }
  }
}

}  // namespace
}  // namespace palpate
