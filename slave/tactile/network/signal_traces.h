// Present and past signals of a fingertip, normalised by their size. Skin creeps for seconds and
// fluid flows, so one sample does not determine the force; contacts that differ only in force have
// similar normalised signals.
#pragma once

#include <array>
#include <cmath>

#include <Eigen/Core>

#include "slave/tactile/signals/tactile_signals.h"

namespace palpate {

// Time constants of the running means in the features, for `rate` [Hz]. [s]
inline constexpr std::array kTraceTimes{0.02, 0.06, 0.3, 1.0, 3.0};

// Number of features of `inputs` signals: 1 + kTraceTimes.size() times as many.
inline constexpr Eigen::Index FeatureCount(Eigen::Index inputs) {
  return inputs * (1 + static_cast<Eigen::Index>(kTraceTimes.size()));
}

class SignalTraces {
 public:
  // `inputs`: the channels, or E1 to E19, pac0, pdc; `rate` [Hz], > 0.
  SignalTraces(Eigen::Index inputs, Eigen::Index channels, double rate)
      : channels_(channels), means_(inputs, kTraceTimes.size()) {
    for (std::size_t k = 0; k < kTraceTimes.size(); ++k) {
      shares_[k] = 1 - std::exp(-1 / (kTraceTimes[k] * rate));
    }
    Reset();
  }

  void Reset() noexcept { means_.setZero(); }

  // Processes the next sample, counts minus baseline over their scale, all finite. Fills `features`
  // and returns the size by which they are normalised [-]: the force is this size times a function
  // of them. Allocation-free.
  double Take(const Eigen::Ref<const Eigen::VectorXd>& now,
              Eigen::Ref<Eigen::VectorXd> features) noexcept {
    const Eigen::Index inputs = means_.rows();
    const double size = std::sqrt(
        now.head(channels_).squaredNorm() / static_cast<double>(channels_) + kMinSize * kMinSize);
    features.head(inputs) = now / size;
    for (std::size_t k = 0; k < kTraceTimes.size(); ++k) {
      const auto column = static_cast<Eigen::Index>(k);
      means_.col(column) += shares_[k] * (now - means_.col(column));
      features.segment((column + 1) * inputs, inputs) = means_.col(column) / size;
    }
    return size;
  }

 private:
  static constexpr double kMinSize = 0.1;  // below this size the features include the size
  Eigen::Index channels_;
  Eigen::MatrixXd means_;  // inputs x traces
  std::array<double, kTraceTimes.size()> shares_{};
};

}  // namespace palpate
