// A network and a localiser with simple known answers for tests.
#pragma once

#include <cmath>
#include <memory>
#include <span>

#include "slave/tactile/localise/localiser.h"
#include "slave/tactile/network/force_network.h"

namespace palpate::testing_fakes {

// The force is the mean of E1, E2 and E3 over the window, in newtons per count.
class MeanNetwork final : public ForceNetwork {
 public:
  static constexpr double kPerCount = 0.01;

  explicit MeanNetwork(int window, double sigma = 0.02, double learnt_force = 0) {
    info_.architecture = "mean";
    info_.inputs = kSignalCount;
    info_.window = window;
    info_.outputs = 3;
    info_.sigma.setConstant(sigma);
    info_.learnt_force = learnt_force;
  }
  // Becomes a sensor without electrodes, with `count` channels that may stay the same.
  void BeOfChannels(int count) {
    info_.inputs = count;
    info_.channels = {count, "kPa"};
    info_.longest_constant = 0;
  }
  [[nodiscard]] const NetworkInfo& info() const override { return info_; }
  [[nodiscard]] std::unique_ptr<ForceEstimate> Windowed() const override {
    return std::make_unique<Estimate>(info_.window);
  }

 private:
  class Estimate final : public ForceEstimate {
   public:
    explicit Estimate(int window)
        : window_(window), seen_(static_cast<std::size_t>(window > 0 ? window : 1)) {}
    void Reset() noexcept override { count_ = 0, sum_.setZero(); }
    bool Push(const TactileSignals& change, std::span<double> outputs) noexcept override {
      const Eigen::Vector3d x(change[0], change[1], change[2]);
      if (!x.allFinite()) {
        Reset();
        return false;
      }
      sum_ += x;
      if (window_ > 0) {
        const auto slot = static_cast<std::size_t>(count_ % window_);
        if (count_ >= window_) sum_ -= seen_[slot];
        seen_[slot] = x;
      }
      ++count_;
      const double share = kPerCount / (window_ > 0 ? window_ : 1);
      for (std::size_t i = 0; i < 3; ++i) outputs[i] = share * sum_[static_cast<Eigen::Index>(i)];
      return window_ == 0 || count_ >= window_;
    }

   private:
    int window_, count_ = 0;
    std::vector<Eigen::Vector3d> seen_;
    Eigen::Vector3d sum_{0, 0, 0};
  };

  NetworkInfo info_;
};

// Reports a contact at the centre of the pad when E4 has changed by five counts. A change of E5
// simulates saturation.
class PadLocaliser final : public Localiser {
 public:
  explicit PadLocaliser(double radius = 7e-3) : radius_(radius) {}
  [[nodiscard]] TouchPlace Locate(const TactileSignals& change,
                                  const FingerReading& raw) const noexcept override {
    TouchPlace place;
    if (!std::isfinite(change[3])) {
      place.status = TouchPlace::Status::kFailed;
    } else if (std::abs(change[3]) >= 5) {
      place.is_flawed = raw.channels[4] >= 4095;
      place.status = place.is_flawed ? TouchPlace::Status::kFlawed : TouchPlace::Status::kFound;
      place.active = 1;
      place.p_F = {0, 0, -radius_};
      place.n_F = {0, 0, -1};
    }
    return place;
  }
  [[nodiscard]] std::string_view name() const override { return "pad"; }

 private:
  double radius_;
};

// Returns a reading from which MeanNetwork and PadLocaliser find this force [N] on the object,
// above rest values of 3000 counts.
inline FingerReading ReadingOf(const Eigen::Vector3d& force_F, bool active) {
  FingerReading reading;
  reading.present = true;
  reading.channels.fill(3000);
  for (std::size_t i = 0; i < 3; ++i) {
    reading.channels[i] +=
        static_cast<float>(force_F[static_cast<Eigen::Index>(i)] / MeanNetwork::kPerCount);
  }
  if (active) reading.channels[3] += 50;
  reading.pac = 2000;
  reading.pdc = 2200;
  return reading;
}

}  // namespace palpate::testing_fakes
