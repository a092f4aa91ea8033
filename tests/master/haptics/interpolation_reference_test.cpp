// The tabulated cases of f_interpolation_scaling.json, which were derived without this code.
#include <cmath>
#include <numbers>

#include <gtest/gtest.h>

#include "master/haptics/force_chain.h"
#include "master/haptics/renderer.h"
#include "tests/support/references.h"

namespace palpate {
namespace {

using reference::json;

constexpr const char* kFile = "f_interpolation_scaling.json";

// Errors of the rendered forces.
struct Error {
  double rms = 0, mean = 0, max = 0;
};

// Shows `signal`, sampled at 60 Hz without delay, at 1 kHz between `from` and `to` [s].
template <class Signal>
Error ErrorOf(bool hold, const Signal& signal, double from, double to) {
  DelayedLinear shown;
  Error error;
  int count = 0, next = 0;
  for (int tick = 0; tick < std::lround(to * 1000); ++tick) {
    const double now = tick / 1000.0;
    for (; next / 60.0 <= now; ++next) {
      shown.Add(next / 60.0, next / 60.0, {signal(next / 60.0), 0, 0});
    }
    if (now < from) continue;
    const double e = (hold ? shown.newest().x() : shown.At(now).x()) - signal(now);
    error.rms += e * e;
    error.mean += e;
    error.max = std::max(error.max, std::abs(e));
    ++count;
  }
  error.rms = std::sqrt(error.rms / count);
  error.mean /= count;
  return error;
}

TEST(InterpolationReferenceTest, ConstantAndRampAreExact) {
  PALPATE_CASE_OR_SKIP(given, kFile, "interpolation_60_to_1000");
  const json& expected = given["expected"];
  const auto constant = [](double) { return 1.5; };
  EXPECT_EQ(ErrorOf(true, constant, 0, 2).max, expected["constant"]["zoh"]);
  EXPECT_EQ(ErrorOf(false, constant, 0, 2).max, expected["constant"]["delayed_linear"]);

  const auto ramp = [](double t) { return 2 * t; };
  const json linear = expected["ramp"]["delayed_linear"];
  const Error delayed = ErrorOf(false, ramp, 0.05, 2.05);
  EXPECT_NEAR(delayed.rms, linear["rms"].get<double>(), 1e-12);
  EXPECT_NEAR(delayed.mean, linear["mean"].get<double>(), 1e-12);
  EXPECT_NEAR(delayed.max, linear["max"].get<double>(), 1e-12);
  // The table holds the continuous-time error of the hold; on ticks that sit at the left end of
  // each millisecond its age is shorter by half a tick, 3 % of its mean.
  const json zoh = expected["ramp"]["zoh"];
  const Error held = ErrorOf(true, ramp, 0.05, 2.05);
  EXPECT_NEAR(held.mean, zoh["mean"].get<double>(), 2 * 0.0005 * 1.01);
  EXPECT_LE(held.max, zoh["max"].get<double>());
}

TEST(InterpolationReferenceTest, SineErrorIsThatOfTheHapticClock) {
  PALPATE_CASE_OR_SKIP(given, kFile, "interpolation_60_to_1000");
  const json& rms = given["cross_check"]["haptic_clock_brute_force_rms"];
  const auto sine = [](double t) { return std::sin(2 * std::numbers::pi * 5 * t); };
  const double zoh = rms["zoh"], linear = rms["delayed_linear"];
  EXPECT_NEAR(ErrorOf(true, sine, 0.2, 3.2).rms / zoh, 1, 1e-3);
  EXPECT_NEAR(ErrorOf(false, sine, 0.2, 3.2).rms / linear, 1, 1e-3);
}

// Renders the case from states by the renderer of the product, in both modes.
TEST(InterpolationReferenceTest, HandCaseIsExactInBothModes) {
  PALPATE_CASE_OR_SKIP(hand, kFile, "interpolation_hand_case");
  const auto samples = hand["params"]["samples"].get<std::vector<double>>();
  const int ticks = hand["params"]["ticks_per_sample"];
  for (const auto& [mode, key] : {std::pair{RenderMode::kHold, "zoh"},
                                  std::pair{RenderMode::kInterpolate, "delayed_linear"}}) {
    Renderer renderer(mode);
    Reasons reasons;
    const auto expected = hand["expected"][key].get<std::vector<double>>();
    for (std::size_t tick = 0; tick < expected.size(); ++tick) {
      const auto now = static_cast<double>(tick);
      SlaveState state;
      state.validity = Validity::kValid;
      state.force = Eigen::Vector3d(samples[tick / static_cast<std::size_t>(ticks)], 0, 0);
      const double sensed = now - std::fmod(now, ticks);
      renderer.Take(state, sensed, now, now);  // repeated states are used once
      EXPECT_NEAR(renderer.Render({0, 0, 0}, now, &reasons).x(), expected[tick], 1e-15)
          << key << " tick " << tick;
    }
  }
}

// Returns the damping [N s/m] that makes a wall K x + B v passive if it is sampled every T and
// rendered `delay` ticks late: the energy that it delivers while the device moves slowly back and
// forth inside it, divided by the integral of v^2.
double DampingNeeded(double K, double B, double T, int delay) {
  PassivityControl port;
  const double omega = 0.5, amplitude = 0.01, mean = 0.05;
  const int period = static_cast<int>(std::lround(2 * std::numbers::pi / omega / T));
  const auto x = [&](int k) {
    return mean + amplitude * std::sin(2 * std::numbers::pi * k / period);
  };
  for (int k = 0; k <= period; ++k) {
    const int seen = k - 1 - delay;  // the force held up to tick k was sampled then
    const double f = -K * x(seen) - B * (x(seen) - x(seen - 1)) / T;
    port.Observe({x(k), 0, 0}, {f, 0, 0}, T);
  }
  const double v2 = std::pow(amplitude * omega, 2) / 2 * period * T;
  return (port.energy_out() - port.energy_in()) / v2;
}

// Reference: b > K T (n + 1/2) - B for slow motion. Tolerance: the terms left out are of the order
// (omega T n)^2 = 6e-5.
TEST(InterpolationReferenceTest, TheObserverCountsTheEnergyOfAVirtualWall) {
  int checked = 0;
  PALPATE_CASE_OR_SKIP(wall, kFile, "passivity_virtual_wall");
  for (const json& row : wall["expected"]["numeric_check"]) {
    const double B = row["B"];
    if (B > 0) continue;  // worst at half the tick rate, not for slow motion
    const double expected = row["b_required_formula"];
    EXPECT_NEAR(DampingNeeded(row["K"], B, row["T"], row["extra_delay_ticks"]) / expected, 1, 1e-4)
        << row.dump();
    ++checked;
  }
  EXPECT_EQ(checked, 4);
}

}  // namespace
}  // namespace palpate
