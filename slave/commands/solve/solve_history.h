// What acts on one place of a body over time.
#pragma once

#include <span>
#include <utility>
#include <vector>

#include <Eigen/Core>

#include "slave/commands/solve/solve_rows.h"

namespace palpate {

class PlaceHistory {
 public:
  // The first row of a place; its width and kind go with it.
  explicit PlaceHistory(const SolveRow& first);

  // The row acts at this place, in this way.
  [[nodiscard]] bool Takes(const SolveRow& row) const;
  void Add(const SolveRow& row);

  // Linear between rows; the first row's value before it, the last one's after it (contracts,
  // `solve`). Without times: constant.
  [[nodiscard]] Contact At(double t) const;
  [[nodiscard]] double end() const { return values_.rbegin()->first; }  // [s]

 private:
  Contact contact_;
  std::vector<std::pair<double, Eigen::Vector3d>> values_;  // by time, then as the rows came
};

// The rows `of_case` of `rows`, by place, in the order of their first rows.
std::vector<PlaceHistory> HistoriesOf(const std::vector<SolveRow>& rows,
                                      std::span<const std::size_t> of_case);

}  // namespace palpate
