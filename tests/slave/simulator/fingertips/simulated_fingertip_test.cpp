#include "slave/simulator/fingertips/simulated_fingertip.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <numbers>

#include <gtest/gtest.h>

#include "slave/tactile/localise/electrode_layout.h"
#include "tests/support/allocation_count.h"

namespace palpate {
namespace {

using Eigen::Vector3d;
constexpr double kPeriod = 0.01;  // [s]
constexpr std::size_t kPac = kElectrodeCount, kPdc = kElectrodeCount + 1;
using Counts = std::array<double, kElectrodeCount + 2>;

// A load of `newtons` towards the finger at the place whose outward normal is along `out`.
FingertipLoad Push(const Vector3d& out, double newtons, double radius) {
  const Vector3d n = out.normalized();
  return {site::kSkinRadius * n, -newtons * n, radius};
}

Counts Mean(SimulatedFingertip* fingertip, const FingertipLoad* load, int samples) {
  Counts mean{};
  for (int i = 0; i < samples; ++i) {
    const FingerReading reading = fingertip->Sample(load, kPeriod);
    for (std::size_t k = 0; k < kElectrodeCount; ++k)
      mean[k] += static_cast<double>(reading.electrodes[k]) / samples;
    mean[kPac] += static_cast<double>(reading.pac) / samples;
    mean[kPdc] += static_cast<double>(reading.pdc) / samples;
  }
  return mean;
}

// Counts minus rest after 0.3 s of `load`, mean of 1 s.
Counts Change(std::uint32_t seed, const FingertipLoad& load) {
  SimulatedFingertip fingertip(seed);
  const Counts rest = Mean(&fingertip, nullptr, 100);
  Mean(&fingertip, &load, 30);
  Counts change = Mean(&fingertip, &load, 100);
  for (std::size_t k = 0; k < change.size(); ++k) change[k] -= rest[k];
  return change;
}

// Reference: area of a half sphere and of a cylinder, 2 pi r^2 + 2 pi r L, in closed form.
TEST(SkinSurface, PiecesAddUpToTheWholeSkin) {
  const site::SkinSurface skin = site::MakeSkinSurface();
  double area = 0;
  for (const double piece : skin.area) area += piece;
  const double r = site::kSkinRadius, L = 16e-3;
  EXPECT_NEAR(area, 2 * std::numbers::pi * r * (r + L), 1e-9 * area);
}

TEST(SimulatedFingertip, HardContactLowersTheElectrodesUnderItAndRaisesTheOthers) {
  const ElectrodeLayout layout = SimulatedLayout(site::kSkinRadius);
  for (std::size_t pressed = 0; pressed < kElectrodeCount; ++pressed) {
    const Vector3d n = layout.n_F[pressed];
    const Vector3d axis(layout.p_F[pressed].x() - (n.x() > 0 ? 1 : 0) * n.x() * 0.78 * 7e-3, 0, 0);
    FingertipLoad load = Push(n, 2, 3e-3);
    load.p_F += axis;
    const Counts change = Change(5, load);
    EXPECT_LT(change[pressed], -100) << "electrode " << pressed + 1;
    EXPECT_EQ(std::min_element(change.begin(), change.begin() + kElectrodeCount) - change.begin(),
              static_cast<std::ptrdiff_t>(pressed));
    const auto rising = std::count_if(change.begin(), change.begin() + kElectrodeCount,
                                      [](double c) { return c > 5; });
    EXPECT_GE(rising, 9) << "electrode " << pressed + 1;
  }
}

// On the recording of a finger on foam 16 to 18 of 19 electrodes rise.
TEST(SimulatedFingertip, NearlyAllElectrodesRiseInSoftWideContact) {
  const Counts change = Change(5, Push({0.1, -0.8, -0.6}, 0.9, 11e-3));
  const auto rising = std::count_if(change.begin(), change.begin() + kElectrodeCount,
                                    [](double c) { return c > 0; });
  EXPECT_GE(rising, 15);
}

TEST(SimulatedFingertip, EverySignalGrowsWithTheForceUpToFiveNewtons) {
  double pdc = 0, spread = 0;
  for (const double newtons : {0.2, 0.5, 1.0, 2.0, 3.5, 5.0}) {
    const Counts change = Change(8, Push({0.3, 0, -1}, newtons, 4e-3));
    const auto [low, high] = std::minmax_element(change.begin(), change.begin() + kElectrodeCount);
    EXPECT_GT(change[kPdc], 1.1 * pdc);
    EXPECT_GT(*high - *low, 1.02 * spread);
    pdc = change[kPdc];
    spread = *high - *low;
  }
  EXPECT_LT(pdc, 1500);  // it stays within its 12 bits
}

// Opposite tangential forces must be told apart by more than the noise of 1 s of samples (0.1).
TEST(SimulatedFingertip, TangentialForceMovesTheSkinTowardsWhereItPoints) {
  FingertipLoad forwards = Push({0, 0, -1}, 1, 5e-3), backwards = forwards;
  forwards.f_F.x() = 0.5;
  backwards.f_F.x() = -0.5;
  const Counts with = Change(3, forwards), against = Change(3, backwards);
  EXPECT_GT(with[0] - against[0], 40);     // E1 is at the tip: skin bunches up there
  EXPECT_LT(with[13] - against[13], -15);  // E14 lies behind
}

TEST(SimulatedFingertip, SkinCreepsUnderAHeldLoadAndComesBack) {
  SimulatedFingertip fingertip(4);
  const FingertipLoad load = Push({0.1, -0.8, -0.6}, 3, 8e-3);
  const Counts rest = Mean(&fingertip, nullptr, 200);
  const auto sum = [&](const Counts& counts) {
    double total = 0;
    for (std::size_t k = 0; k < kElectrodeCount; ++k) total += std::abs(counts[k] - rest[k]);
    return total;
  };
  const double early = sum(Mean(&fingertip, &load, 10));
  Mean(&fingertip, &load, 300);
  EXPECT_GT(sum(Mean(&fingertip, &load, 50)), 1.02 * early);
  const double left = sum(Mean(&fingertip, nullptr, 10));
  EXPECT_GT(left, 0.01 * early);
  Mean(&fingertip, nullptr, 500);
  EXPECT_LT(sum(Mean(&fingertip, nullptr, 50)), 0.5 * left);
}

}  // namespace
}  // namespace palpate
