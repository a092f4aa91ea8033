#include "slave/simulator/presses/simulated_presses.h"

#include <algorithm>
#include <cmath>
#include <numbers>
#include <random>
#include <stdexcept>

#include "slave/simulator/fingertips/simulated_fingertip.h"

namespace palpate {
namespace {

using Eigen::Vector3d;

constexpr double kPeriod = 1 / kPressRate;  // [s]
constexpr double kRadius = 7e-3;            // of the fingertip [m]
constexpr double kSideways = 1.2;           // largest angle from the pad's centre [rad]
constexpr double kUpwards = 1.3;            // furthest place towards the tip [rad]
constexpr double kBackwards = 14e-3;        // furthest place behind the tip's sphere [m]
constexpr double kSoftest = 2e3;            // objects' modulus E / (1 - nu^2): foam [Pa]
constexpr double kHardest = 1e7;            // hard rubber; the skin itself yields more [Pa]
constexpr double kWidestProbe = 3e-3, kWidestContact = 12e-3;  // radii [m]
constexpr double kFlattest = 2.2;   // contact width on a flat object relative to that on a sphere
constexpr double kLonger = 1.5;     // factor on the width if the whole pad touches
constexpr double kGentlest = 0.01;  // smallest peak force, relative to the largest one
constexpr double kFriction = 0.5;   // largest tangential force, relative to the normal one

class Dice {
 public:
  explicit Dice(std::uint64_t seed) : random_(seed) {}
  double Between(double low, double high) {
    return low + (high - low) * (static_cast<double>(random_() >> 11) * 0x1p-53);
  }
  // Draws a number between `low` and `high` with uniformly distributed logarithm.
  double Ratio(double low, double high) { return low * std::pow(high / low, Between(0, 1)); }

 private:
  std::mt19937_64 random_;
};

// A number that moves smoothly between values drawn at random.
class Wave {
 public:
  Wave(double low, double high, Dice* dice) : middle_((low + high) / 2), size_((high - low) / 2) {
    for (Part& part : parts_) {
      part = {dice->Between(0.2, 2), dice->Between(0, 2 * std::numbers::pi)};
    }
  }
  [[nodiscard]] double At(double t) const {
    double sum = 0;
    for (const Part& part : parts_)
      sum += std::sin(2 * std::numbers::pi * part.rate * t + part.phase);
    return middle_ + size_ * sum / static_cast<double>(parts_.size());
  }

 private:
  struct Part {
    double rate, phase;  // [Hz], [rad]
  };
  double middle_, size_;
  std::array<Part, 2> parts_{};
};

// One press from the first to the last contact sample.
class Press {
 public:
  Press(double largest_force, Dice* dice)
      : peak_(largest_force * dice->Ratio(kGentlest, 1)),
        rise_(dice->Ratio(0.1, 1.5)),
        hold_(dice->Between(0.3, 2.5)),
        fall_(dice->Ratio(0.1, 1.2)),
        probe_radius_(dice->Between(0, kWidestProbe)),
        modulus_(dice->Ratio(kSoftest, kHardest)),
        upwards_(dice->Between(-kUpwards / 2, kUpwards)),
        backwards_(upwards_ > 0 ? 0 : kBackwards * std::pow(dice->Between(0, 1), 2)),
        max_scale_(upwards_ > 0 ? 1 : kLonger),
        flatness_(dice->Between(1, max_scale_ * kFlattest)),
        sideways_(dice->Between(-kSideways, kSideways)),
        roll_(-0.1, 0.1, dice),
        level_(0.7, 1, dice),
        along_(-kFriction, kFriction, dice),
        across_(-kFriction, kFriction, dice) {}

  [[nodiscard]] double duration() const { return rise_ + hold_ + fall_; }
  [[nodiscard]] FingertipLoad At(double t) const {
    const double up = std::clamp(t / rise_, 0.0, 1.0);
    const double down = std::clamp((duration() - t) / fall_, 0.0, 1.0);
    const double normal_force = peak_ * level_.At(t) * Smooth(std::min(up, down));
    const double side = sideways_ + roll_.At(t);
    const double up_angle = std::max(upwards_, 0.0);
    const Vector3d normal(std::sin(up_angle), std::cos(up_angle) * std::sin(side),
                          -std::cos(up_angle) * std::cos(side));
    const Vector3d u = normal.unitOrthogonal(), v = normal.cross(u);
    FingertipLoad load;
    load.p_F = kRadius * normal - Vector3d(backwards_, 0, 0);
    load.f_F = normal_force * (-normal + along_.At(t) * u + across_.At(t) * v);
    // Hertz: a sphere on an elastic half space, 3 F R = 4 E a^3; on its side a fingertip is not a
    // sphere. The contact width is limited by the probe and by the pad.
    const double hertz = flatness_ * std::cbrt(0.75 * normal_force * kRadius / modulus_);
    load.radius = std::min(std::max(probe_radius_, hertz), max_scale_ * kWidestContact);
    return load;
  }

 private:
  static double Smooth(double x) { return x * x * (3 - 2 * x); }
  double peak_, rise_, hold_, fall_, probe_radius_, modulus_, upwards_, backwards_, max_scale_,
      flatness_, sideways_;
  Wave roll_, level_, along_, across_;
};

int Samples(double seconds) {
  return static_cast<int>(std::lround(seconds / kPeriod));
}

}  // namespace

int CountStarts(const SimulatedPresses& options) {
  if (options.presses < 1 || options.per_start < 1 || options.rest_samples < 1 ||
      !(options.largest_force > 0)) {
    throw std::invalid_argument(
        "simulated contacts: expected 1 or more contacts, 1 or more per start, 1 or more rest "
        "samples, a largest force > 0");
  }
  return (options.presses + options.per_start - 1) / options.per_start;
}

SimulatedStart SimulateStart(const SimulatedPresses& options, int start) {
  // Every start has separate random numbers, so more presses do not change earlier ones.
  const std::uint64_t seed = options.seed * 1'000'003 + static_cast<std::uint64_t>(start);
  Dice dice(seed);
  SimulatedFingertip fingertip(static_cast<std::uint32_t>(seed ^ (seed >> 32)));
  SimulatedStart recorded;
  const auto record = [&](const FingertipLoad* load) {
    recorded.readings.push_back(fingertip.Sample(load, kPeriod));
    recorded.force.push_back(load == nullptr ? Vector3d(0, 0, 0) : Vector3d(-load->f_F));
  };
  for (int i = 0; i < options.rest_samples + 20; ++i) record(nullptr);
  const int presses = std::min(options.per_start, options.presses - start * options.per_start);
  for (int k = 0; k < presses; ++k) {
    const Press press(options.largest_force, &dice);
    for (int i = 0; i < Samples(press.duration()); ++i) {
      const FingertipLoad load = press.At(kPeriod * i);
      record(&load);
    }
    const int pause = Samples(dice.Between(0.6, 2));
    for (int i = 0; i < pause; ++i) record(nullptr);
  }
  return recorded;
}

}  // namespace palpate
