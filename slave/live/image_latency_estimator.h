// Detects images that show another time than their timestamps, for example after waiting in a
// driver's queue, by comparing their motion with the encoders. A wrong timestamp assigns a correct
// force to the wrong time; the error is the change of force in between.
#pragma once

#include <algorithm>
#include <cmath>
#include <optional>

#include <Eigen/Core>

#include "shared/state/clock.h"
#include "slave/manipulator/arm_fit.h"
#include "slave/pipeline/base/estimate_builder.h"

namespace palpate {

// For a real manipulator. Independent of the origin and step size of its encoders: it compares the
// two motions. Not thread-safe, allocation-free.
class ImageLatencyEstimator {
 public:
  static constexpr double kMost = 0.1;  // larger latency is flagged [s]

  // Widens and flags one estimate. `seen`: position in the image; `arm`: encoder reading at the
  // image's timestamp [m]; `sigma`: of `seen` [m].
  void Update(const Eigen::Vector3d& seen, const Eigen::Vector3d& arm, double sigma,
              ContactEstimate* estimate) noexcept {
    Go(estimate->sensed_at);
    const double dt = last_ ? SecondsBetween(last_->at, estimate->sensed_at) : 0;
    if (dt > 0 && dt < kGap) {
      const Eigen::Vector3d way = arm - last_->arm;
      const double kept = std::exp(-dt / kMemory);
      speed_ = std::max(way.norm() / dt, kept * speed_);
      in_speed_ = std::max(std::abs(estimate->local_model.normal.dot(way)) / dt, kept * in_speed_);
      fit_.Add(seen, arm, way / dt, dt);
      double scale = 1;
      if (const auto found = fit_.found()) {
        follows_ = found->scale > kFollows;
        late_ = std::hypot(found->lag, kOpen);
        scale = std::clamp(found->scale, kFollows, 1 / kFollows);
      }
      const Eigen::Vector3d change = seen - last_->seen, apart = change - scale * way;
      const double floor = kLeapSigmas * sigma;
      // No latency explains a constant difference: the images and the manipulator are both
      // stationary.
      const bool follows = way.norm() > floor && apart.norm() < kFollows * way.norm();
      gap_ = (distrust_ > 0 && !follows ? 1 : kept) * gap_ + apart;
      const bool leaps =
          (change - way).norm() > kLeap * speed_ + floor || gap_.norm() > kOpenGap * speed_ + floor;
      distrust_ = leaps ? kDistrust : std::max(0.0, distrust_ - dt);
      open_ = std::max(0.0, gap_.norm() - floor);
    }
    Widen(estimate);
    if (distrust_ > 0 || late_ > kMost)
      estimate->Fail(FailedCheck::kInstants, "images and manipulator are of different instants");
    if (!follows_) estimate->Fail(FailedCheck::kArm, "the tip does not follow the manipulator");
    last_ = Last{seen, arm, estimate->sensed_at};
  }
  // No moving object is visible in an image of this time.
  void Miss(Time at) noexcept {
    Go(at);
    last_.reset();
    gap_.setZero();
    open_ = 0;
  }

 private:
  static constexpr double kMemory = 0.5;    // [s]
  static constexpr double kGap = 0.5;       // time without an image after which all is cleared [s]
  static constexpr double kLeap = 0.06;     // path of the manipulator between two images [s]
  static constexpr double kOpenGap = 0.12;  // path of the manipulator over kMemory [s]
  static constexpr double kLeapSigmas = 8;  // in addition
  static constexpr double kDistrust = 0.7;  // after a leap, till it is known how late they are [s]
  static constexpr double kUnknown = 0.02;  // before it has moved to and fro: one sigma [s]
  static constexpr double kFollows =
      0.5;  // least share of the manipulator's path that the images show
  static constexpr double kOpen = 2e-3;  // margin in addition to the estimate [s]

  struct Last {
    Eigen::Vector3d seen, arm;
    Time at{};
  };

  // After a driver reconnects the latency is unknown.
  void Go(Time at) noexcept {
    if (SecondsBetween(at_, at) > kGap) *this = {};
    at_ = at;
  }

  // Change of the manipulator's depth since the image, inwards or outwards. It slows down where it
  // reverses, and a free tool may touch.
  void Widen(ContactEstimate* estimate) noexcept {
    const LocalModel& local = estimate->local_model;
    if (!estimate->force || !local.known()) return;
    const double above =
        estimate->depth > 0 ? 0 : std::max(0.0, -local.Penetration(estimate->p_S_tip));
    const double gone = std::max({0.0, late_ * in_speed_ - above, open_ - above});
    const double more = gone * local.normal.dot(local.stiffness * local.normal);
    estimate->sigma = std::hypot(estimate->sigma, more);
    const double force = estimate->force->norm();
    if (!estimate->moment || force == 0) return;
    estimate->moment_sigma =
        std::hypot(estimate->moment_sigma, more * estimate->moment->norm() / force);
  }

  Time at_{};  // of the last image
  ArmFit fit_{kMemory};
  std::optional<Last> last_;
  Eigen::Vector3d gap_{0, 0, 0};           // recent difference of images and encoders [m]
  double open_ = 0;                        // part of it beyond the noise [m]
  double late_ = kUnknown, distrust_ = 0;  // one sigma [s]
  bool follows_ = true;
  double speed_ = 0,
         in_speed_ = 0;  // largest recent speed of the manipulator, along the normal [m/s]
};

}  // namespace palpate
