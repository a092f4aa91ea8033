// How many of the eyes' points were followed over a run, and how well.
#pragma once

#include <cstdint>
#include <vector>

#include "slave/vision/stereo/surface_points.h"

namespace palpate {

class TrackingCounts {
 public:
  // `counts`: a point that is not seen was missed; otherwise, while the rest frame is taken, it may
  // still come.
  void Add(const std::vector<SurfacePoint>& points, bool counts) {
    rows_.resize(points.size());
    for (std::size_t i = 0; i < points.size(); ++i) {
      rows_[i].was_seen |= points[i].seen;
      if (counts && !points[i].seen) ++rows_[i].missed;
    }
  }
  [[nodiscard]] std::size_t points() const { return rows_.size(); }
  // Seen at least once.
  [[nodiscard]] std::size_t followed() const {
    std::size_t count = 0;
    for (const Row& row : rows_) count += row.was_seen ? 1 : 0;
    return count;
  }
  // Times that one of those followed was not seen.
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

}  // namespace palpate
