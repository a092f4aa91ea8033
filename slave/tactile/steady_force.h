// The force of signals noisier than the network learnt from, averaged in what lasts.
#pragma once

#include <algorithm>
#include <utility>

#include <Eigen/Core>

namespace palpate {

// How large a force is shows in how far the signals are from rest, sample by sample: that is taken
// as it comes, so that nothing lags. Which way it points hardly changes while a contact lasts, nor
// what there is of it per count of the signals: these are averaged over the longer the noisier the
// signals are, larger ones counting more. A contact that is lost from one sample to the next takes
// its force along; one that turns is followed within so many samples, and `left_out` says how far.
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
  // What averaging has left out, of the last few samples: noise, or that the contact turns; of the
  // newest alone at least half, lest one that turns at once be told as it was [N].
  [[nodiscard]] double left_out() const noexcept {
    return std::max(left_out_.norm(), kNewest * newest_.norm());
  }

 private:
  static constexpr double kTurns = 6, kGrows = 1.5;  // samples per usual noise
  static constexpr double kBriskly = 0.3;            // share of a sample in what is left out
  static constexpr double kNewest = 0.5;             // part of what the newest one leaves out

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
