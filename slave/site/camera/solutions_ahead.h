// Solves contacts before they happen: while the tool comes near, a thread of its own computes the
// solution for the place where it will touch, so that the instant of contact costs nothing.
#pragma once

#include <condition_variable>
#include <deque>
#include <memory>
#include <mutex>
#include <optional>
#include <string>
#include <thread>
#include <utility>

#include "slave/site/camera/patch_solution.h"
#include "slave/site/camera/true_body.h"

namespace palpate::site {

class SolutionsAhead {
 public:
  // `body` must outlive this. `width` [m].
  SolutionsAhead(const TrueBody& body, double poisson_ratio, Plane plane, double width);
  ~SolutionsAhead();

  // A contact near `place` is to be expected. Returns at once; the newest request wins.
  void Expect(const BoundaryPlace& place);
  // The solution nearest to `place` on the raster of places, waiting for it if need be (10 to 40
  // ms). nullptr: it could not be solved.
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
  double width_;
  double raster_;  // [m]

  std::mutex mutex_;  // guards what follows
  std::condition_variable_any changed_;
  std::optional<Key> wanted_;
  std::deque<Entry> entries_;  // newest first
  std::jthread thread_;        // last: it uses everything above
};

}  // namespace palpate::site
