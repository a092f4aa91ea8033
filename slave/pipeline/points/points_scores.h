// Scores of a run over points: errors of their positions, the number of tracked points, and
// contacts that pause at depth after depth.
#pragma once

#include <algorithm>
#include <cmath>
#include <cstdint>
#include <optional>
#include <vector>

#include <Eigen/Core>
#include <nlohmann/json_fwd.hpp>

#include "slave/vision/stereo/surface_points.h"

namespace palpate {

// Errors of the measured points relative to the simulator's true positions.
class ErrorOfPoints {
 public:
  // `error`: measured minus true, of one point in one pair [m].
  void Add(const Eigen::Vector3d& error) {
    ++count_;
    squares_ += error.squaredNorm();
    peak_ = std::max(peak_, error.norm());
  }
  [[nodiscard]] std::uint64_t count() const { return count_; }
  [[nodiscard]] double rms() const {  // [m]
    return count_ > 0 ? std::sqrt(squares_ / static_cast<double>(count_)) : 0;
  }
  [[nodiscard]] double peak() const { return peak_; }  // [m]

 private:
  std::uint64_t count_ = 0;
  double squares_ = 0, peak_ = 0;
};

// Number of points that were followed over a run, and the quality of their tracking.
class TrackingCounts {
 public:
  // `counts`: an invisible point is counted as missed. False while the baseline is measured, when
  // points may still be detected.
  void Add(const std::vector<SurfacePoint>& points, bool counts) {
    rows_.resize(points.size());
    for (std::size_t i = 0; i < points.size(); ++i) {
      rows_[i].was_seen |= points[i].seen;
      if (counts && !points[i].seen) ++rows_[i].missed;
    }
  }
  [[nodiscard]] std::size_t points() const { return rows_.size(); }
  // Number of points that were seen at least once.
  [[nodiscard]] std::size_t followed() const {
    std::size_t count = 0;
    for (const Row& row : rows_) count += row.was_seen ? 1 : 0;
    return count;
  }
  // Number of times that a followed point was not seen.
  [[nodiscard]] std::uint64_t missed() const {
    std::uint64_t sum = 0;
    for (const Row& row : rows_) sum += row.was_seen ? row.missed : 0;
    return sum;
  }

 private:
  struct Row {
    bool was_seen = false;
    std::uint64_t missed = 0;
  };
  std::vector<Row> rows_;
};

// One halt of a contact that halts at depth after depth, as in paper C's experiment (5.1, figures 5
// and 6): estimated and true values.
struct PressStep {
  double depth = 0;        // true, of the tool [m]
  double true_force = 0;   // size [N]
  int pairs = 0;           // number of image pairs with a known force
  double force = 0;        // estimated, mean of their sizes [N]
  double force_error = 0;  // the largest |estimated - true| of a pair [N]
  ErrorOfPoints displacement;
};

// Sorts pairs into steps: those in a row at one true depth.
class PressSteps {
 public:
  // The points' errors of the pair for the next Add().
  void Add(const Eigen::Vector3d& displacement_error) { points_.push_back(displacement_error); }
  // `force`: size [N]; nullopt: unknown.
  void Add(double depth, double true_force, const std::optional<double>& force);
  // Returns the steps of three or more pairs with a known force, up to the deepest one. During the
  // retreat the tool does not pause.
  [[nodiscard]] std::vector<PressStep> steps() const;

 private:
  std::vector<PressStep> steps_;
  std::vector<Eigen::Vector3d> points_;
};

// The entry of summary.json.
nlohmann::ordered_json ToJson(const std::vector<PressStep>& steps);

}  // namespace palpate
