// Pictures that show another moment than their stamps tell, as those that wait in a driver's queue
// do: what moves in them is held against the arm that moves it. A force that is right for its
// pictures is wrong for their stamps, by what it changes meanwhile.
#pragma once

#include <algorithm>
#include <cmath>
#include <optional>

#include <Eigen/Core>

#include "shared/state/clock.h"
#include "slave/manipulator/arm_fit.h"
#include "slave/pipeline/estimate_builder.h"

namespace palpate {

// Of a real arm. Wherever its frame begins and however large its steps are: what counts is how far
// the one follows the other. Not thread-safe, allocation-free.
class ImageLatencyEstimator {
 public:
  static constexpr double kMost = 0.1;  // what is later is doubted [s]

  // One estimate, which is widened and doubted. `seen`: what moves, as the pictures show it; `arm`:
  // as the arm says, at the picture's stamp [m]; `sigma`: of `seen` [m].
  void Update(const Eigen::Vector3d& seen, const Eigen::Vector3d& arm, double sigma,
              ContactEstimate* felt) noexcept {
    Go(felt->sensed_at);
    const double dt = last_ ? SecondsBetween(last_->at, felt->sensed_at) : 0;
    if (dt > 0 && dt < kGap) {
      const Eigen::Vector3d way = arm - last_->arm;
      const double kept = std::exp(-dt / kMemory);
      speed_ = std::max(way.norm() / dt, kept * speed_);
      in_speed_ = std::max(std::abs(felt->local_model.normal.dot(way)) / dt, kept * in_speed_);
      fit_.Add(seen, arm, way / dt, dt);
      double scale = 1;
      if (const auto found = fit_.found()) {
        follows_ = found->scale > kFollows;
        late_ = std::hypot(found->lag, kOpen);
        scale = std::clamp(found->scale, kFollows, 1 / kFollows);
      }
      const Eigen::Vector3d change = seen - last_->seen, apart = change - scale * way;
      const double floor = kLeapSigmas * sigma;
      // No time closes what is open: pictures that stand stay apart from an arm that stands, too.
      const bool follows = way.norm() > floor && apart.norm() < kFollows * way.norm();
      gap_ = (distrust_ > 0 && !follows ? 1 : kept) * gap_ + apart;
      const bool leaps =
          (change - way).norm() > kLeap * speed_ + floor || gap_.norm() > kOpenGap * speed_ + floor;
      distrust_ = leaps ? kDistrust : std::max(0.0, distrust_ - dt);
      open_ = std::max(0.0, gap_.norm() - floor);
    }
    Widen(felt);
    if (distrust_ > 0 || late_ > kMost) EstimateBuilder::Flag(FailedCheck::kInstants, felt);
    if (!follows_) EstimateBuilder::Flag(FailedCheck::kArm, felt);
    last_ = Last{seen, arm, felt->sensed_at};
  }
  // Nothing that moves is seen in a picture of then.
  void Miss(Time at) noexcept {
    Go(at);
    last_.reset();
    gap_.setZero();
    open_ = 0;
  }
  [[nodiscard]] double late() const { return late_; }  // one sigma [s]

 private:
  static constexpr double kMemory = 0.5;    // [s]
  static constexpr double kGap = 0.5;       // without a picture: all is forgotten [s]
  static constexpr double kLeap = 0.06;     // of the arm's way, between two pictures [s]
  static constexpr double kOpenGap = 0.12;  // of it, over kMemory [s]
  static constexpr double kLeapSigmas = 8;  // besides
  static constexpr double kDistrust = 0.7;  // after a leap, till it is known how late they are [s]
  static constexpr double kUnknown = 0.02;  // before it has moved to and fro: one sigma [s]
  static constexpr double kFollows = 0.5;   // of the arm's way, what is seen goes at least
  static constexpr double kOpen = 2e-3;     // beside what is found [s]

  struct Last {
    Eigen::Vector3d seen, arm;
    Time at{};
  };

  // Of a driver that went and came back nothing is known.
  void Go(Time at) noexcept {
    if (SecondsBetween(at_, at) > kGap) *this = {};
    at_ = at;
  }

  // By how far the arm may have gone in or out since. It slows down where it turns back, and what
  // is not touched yet may be.
  void Widen(ContactEstimate* felt) noexcept {
    const LocalModel& local = felt->local_model;
    if (!felt->force || !local.known()) return;
    const double above = felt->depth > 0 ? 0 : std::max(0.0, -local.Penetration(felt->p_S_tip));
    const double gone = std::max({0.0, late_ * in_speed_ - above, open_ - above});
    felt->sigma = std::hypot(felt->sigma, gone * local.normal.dot(local.stiffness * local.normal));
  }

  Time at_{};  // of the last picture
  ArmFit fit_{kMemory};
  std::optional<Last> last_;
  Eigen::Vector3d gap_{0, 0, 0};           // of what is seen from the arm, of late [m]
  double open_ = 0;                        // what of that is more than noise [m]
  double late_ = kUnknown, distrust_ = 0;  // [s]
  bool follows_ = true;
  double speed_ = 0, in_speed_ = 0;  // the arm's largest of late, that along the normal [m/s]
};

}  // namespace palpate
