// Solutions of contacts of the simulated planar object, made before the tool arrives.
#pragma once

#include <condition_variable>
#include <deque>
#include <memory>
#include <mutex>
#include <optional>
#include <thread>
#include <utility>

#include "slave/reference/planar/patch_solution.h"

namespace palpate::site {

// Solves contacts in advance: while the tool approaches, a separate thread computes the solution
// for the expected contact point, so that the start of contact costs nothing.
class SolutionsAhead {
 public:
  // `body` must outlive this. `width` and, of a round tool, `radius` [m].
  SolutionsAhead(const TrueBody& body, double poisson_ratio, Plane plane, double width,
                 double radius = 0);
  ~SolutionsAhead();

  // Requests a solution near `place`. Returns at once; the newest request counts.
  void Expect(const BoundaryPlace& place);
  // The solution nearest to `place` on the raster of contact points; waits for it if necessary (10
  // to 40 ms). nullptr: it could not be solved.
  std::shared_ptr<const PatchSolution> Await(const BoundaryPlace& place);

 private:
  using Key = std::pair<int, long>;  // loop, multiple of the raster
  struct Entry {
    Key key;
    std::shared_ptr<const PatchSolution> solution;
  };

  [[nodiscard]] Key KeyOf(const BoundaryPlace& place) const;
  [[nodiscard]] const Entry* Find(const Key& key) const;  // with mutex_ held
  [[nodiscard]] std::shared_ptr<const PatchSolution> Solve(const Key& key) const noexcept;
  void Run(const std::stop_token& stop);

  const TrueBody& body_;
  double poisson_ratio_;
  Plane plane_;
  double width_, radius_;  // [m]
  double raster_;          // [m]

  std::mutex mutex_;  // guards what follows
  std::condition_variable_any changed_;
  std::optional<Key> wanted_;
  std::deque<Entry> entries_;  // newest first
  std::jthread thread_;        // last: it uses everything above
};

}  // namespace palpate::site
