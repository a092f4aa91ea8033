// Compares live estimates with a real manipulator: latency of the images, and where its encoders
// have their origin.
#pragma once

#include <optional>

#include "slave/live/image_latency_estimator.h"
#include "slave/live/operator_port.h"
#include "slave/manipulator/manipulator.h"
#include "slave/pipeline/base/sensing_pipeline.h"

namespace palpate {

// Used by the sensing thread.
class ArmComparison {
 public:
  // `shows_arm`: a real manipulator in live images.
  explicit ArmComparison(bool shows_arm) : shows_arm_(shows_arm) {}

  // The sensing is known: `resolution` of the tip [m], 0: it does not measure the tip.
  void Begin(double resolution, const Manipulator& manipulator) {
    resolution_ = resolution;
    registration_.reset();
    // There is something to measure where the tip is sensed and the arm carries it. What is slower
    // than the resolution is at rest.
    if (resolution > 0 && manipulator.carries_tool()) registration_.emplace(resolution);
  }
  // Widens and flags an estimate, by the tip where it is measured, else by the depth. `p_S_arm`:
  // encoder reading at the time of the sample [m].
  void Update(const Eigen::Vector3d& p_S_arm, ContactEstimate* estimate) noexcept {
    if (!shows_arm_) return;
    if (estimate->validity == Validity::kTrackingLost) return latency_.Miss(estimate->sensed_at);
    if (resolution_ > 0) return latency_.Update(estimate->p_S_tip, p_S_arm, resolution_, estimate);
    const LocalModel& local = estimate->local_model;
    const double stiffness = local.normal.dot(local.stiffness * local.normal);
    if (!estimate->force || !(estimate->depth > 0) || !(stiffness > 0)) {
      return latency_.Miss(estimate->sensed_at);
    }
    latency_.Update({estimate->depth, 0, 0}, {-local.normal.dot(p_S_arm), 0, 0},
                    estimate->sigma / stiffness, estimate);
  }
  // Measures the difference of tip and encoders, which `port` uses.
  void Register(const ContactEstimate& estimate, const Eigen::Vector3d& p_S_arm,
                OperatorPort* port) {
    if (!registration_ || estimate.validity == Validity::kTrackingLost) return;
    registration_->Add(estimate.p_S_tip, p_S_arm);
    port->SetRegistration(registration_->offset());
  }

 private:
  bool shows_arm_;
  double resolution_ = 0;  // [m]
  ImageLatencyEstimator latency_;
  std::optional<TipRegistration> registration_;
};

}  // namespace palpate
