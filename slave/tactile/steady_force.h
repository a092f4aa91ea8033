// Averages the force of signals that are noisier than the network's training data.
#pragma once

#include <algorithm>
#include <utility>

#include <Eigen/Core>

namespace palpate {

// The magnitude of the force follows the distance of the signals from the baseline and is used
// sample by sample, without lag. Its direction and its ratio to that distance hardly change during
// a contact. They are averaged, for longer with noisier signals, with larger weights for larger
// signals. A contact that ends between two samples ends the force at once. A rotating contact is
// followed within a number of samples, and `left_out` states the difference.
class SteadyForce {
 public:
  void Reset() noexcept { *this = {}; }
  // The next sample's force [N] and the size of its signals, counts minus rest; `noise` of these,
  // over the usual one: up to 1 nothing is averaged. Allocation-free.
  Eigen::Vector3d Take(const Eigen::Vector3d& force, double size, double noise) noexcept {
    const double norm = force.norm(), more = std::max(0.0, noise - 1);
    if (!(size > 0 && norm > 0)) return force;
    way_.Take(force / norm, size * size, 1 + kTurns * more);
    ratio_.Take(norm / size, size * size, 1 + kGrows * more);
    const Eigen::Vector3d steady = size * ratio_.mean * way_.mean.stableNormalized();
    newest_ = force - steady;
    left_out_ += kBriskly * (newest_ - left_out_);
    return steady;
  }
  // The difference due to averaging over the last few samples: noise, or rotation of the contact;
  // at least half of the newest one alone [N].
  [[nodiscard]] double left_out() const noexcept {
    return std::max(left_out_.norm(), kNewest * newest_.norm());
  }

 private:
  static constexpr double kTurns = 6, kGrows = 1.5;  // samples per usual noise
  static constexpr double kBriskly = 0.3;            // weight of a sample in the difference
  static constexpr double kNewest = 0.5;             // part of the newest sample's difference

  template <typename Value>
  struct Average {
    Value mean{};
    double weight = 0;
    // Over `samples` at most, >= 1: of those before, none counts more than this one.
    void Take(const Value& value, double by, double samples) noexcept {
      weight = std::min((1 - 1 / samples) * weight, (samples - 1) * by) + by;
      mean += by / weight * (value - mean);
    }
  };
  Average<Eigen::Vector3d> way_{Eigen::Vector3d::Zero()};
  Average<double> ratio_;
  Eigen::Vector3d left_out_{0, 0, 0}, newest_{0, 0, 0};
};

}  // namespace palpate
