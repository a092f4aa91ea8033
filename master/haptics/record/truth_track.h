// The true force over time, pieced together from the states that carried it: linear between them.
#pragma once

#include <deque>
#include <optional>

#include <Eigen/Core>

#include "shared/state/clock.h"

namespace palpate {

class TruthTrack {
 public:
  // `at` must not lie before the last; an equal one is ignored.
  void Add(Time at, const Eigen::Vector3d& force_S);
  // Truth at `t` [N]; nothing before the first sample, after the last, or between two that lie more
  // than 100 ms apart.
  [[nodiscard]] std::optional<Eigen::Vector3d> At(Time t) const;
  // A sample at `t` or later has come.
  [[nodiscard]] bool Reaches(Time t) const { return !samples_.empty() && samples_.back().at >= t; }
  // Forgets what At(t) and later do not need.
  void DropBefore(Time t);

 private:
  struct Sample {
    Time at;
    Eigen::Vector3d force;
  };
  std::deque<Sample> samples_;
};

}  // namespace palpate
