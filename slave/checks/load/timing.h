// An error of the timestamps is an error of the force, by what the force changes meanwhile.
#pragma once

#include <algorithm>
#include <cmath>
#include <optional>
#include <utility>

#include "slave/checks/load/load_sample.h"

namespace palpate {

class TimingCheck final : public Check<LoadSample> {
 public:
  // The larger of two changes, since where the tool turns back there seems to be none. What is no
  // more than noise is no change.
  void Examine(const LoadSample& sample, Findings* findings) noexcept override {
    if (!IsForceKnown(sample.load.validity)) return;
    const double force = sample.load.force;
    const double change = last_force_ ? std::abs(force - *last_force_) : 0;
    last_force_ = force;
    const double largest = std::max(change, std::exchange(last_change_, change));
    const double noise = kNoChange * std::hypot(sample.load.sigma_force, findings->sigma_force);
    findings->Widen(sample.seen.moment_sigma * std::max(0.0, largest - noise));
  }
  void Reset() noexcept override {
    last_force_.reset();
    last_change_ = 0;
  }

 private:
  // Change of the force from pair to pair that is noise [sigma]. [tuned: skew_test]
  static constexpr double kNoChange = 2;
  std::optional<double> last_force_;  // outward [N]
  double last_change_ = 0;            // from the one before it [N]
};

}  // namespace palpate
