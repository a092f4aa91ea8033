// The force of the samples in a network's window, and its sigma.
#pragma once

#include <memory>
#include <optional>
#include <vector>

#include <Eigen/Core>

#include "slave/scene/scene.h"
#include "slave/tactile/network/force_network.h"
#include "slave/tactile/signal_model.h"

namespace palpate {

class WindowForce {
 public:
  // Weight of a sample in short-term means [-].
  static constexpr double kBriskly = 0.3;

  // `network` null: forces are unknown. It must outlive this object.
  explicit WindowForce(const ForceNetwork* network);

  // The next sample starts a new window.
  void Reset() noexcept;
  // Adds a sample, counts minus baseline. Returns whether the window is full.
  bool Push(const TactileSignals& change) noexcept {
    return estimate_ && estimate_->Push(change, outputs_);
  }
  // Adds `missed` samples between the last one and `change`.
  void Bridge(const TactileSignals& change, int missed) noexcept;

  struct Estimate {
    std::optional<Eigen::Vector3d> force_F;  // of the fingertip on the object [N]; nullopt: unknown
    double sigma = 0;                        // rms error of the vector [N]
  };
  // Returns the force for a constant change of the channels; nullopt: unknown. Starts a new window.
  [[nodiscard]] std::optional<Eigen::Vector3d> ForceOf(const TactileSignals& change) noexcept;
  // Call once per sample, after Push, which returned `is_full`. `before_F`: force of the last
  // sample; `signals`: model of the same samples, null: unknown.
  [[nodiscard]] Estimate Take(const TactileSignals& change, bool is_full,
                              const std::optional<Eigen::Vector3d>& before_F,
                              const SignalModel* signals) noexcept;
  // Contact point of the network, frame F [m]; nullopt: it has no such output, or the window is not
  // full.
  [[nodiscard]] const std::optional<Eigen::Vector3d>& contact_point() const { return contact_F_; }
  // Returns the change of the force per sample, at present [N].
  [[nodiscard]] double pace() const noexcept { return std::max(pace_F_.norm(), step_); }
  [[nodiscard]] bool has_network() const { return estimate_ != nullptr; }
  [[nodiscard]] const NetworkInfo& network() const { return network_; }

 private:
  [[nodiscard]] double SigmaOf(const Eigen::Vector3d& force_F,
                               const SignalModel* signals) const noexcept;

  NetworkInfo network_;
  std::unique_ptr<ForceEstimate> estimate_;
  std::vector<double> outputs_;
  std::optional<Eigen::Vector3d> contact_F_;
  TactileSignals last_{};            // of the last sample
  Eigen::Vector3d pace_F_{0, 0, 0};  // of the force, averaged over some samples [N/sample]
  double step_ = 0;                  // of the force, in the last sample [N]
  double leap_ = 0;                  // change in the last sample beyond the pace [N]
};

}  // namespace palpate
