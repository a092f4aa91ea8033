// Solutions of contacts of the simulated planar object, made before the tool arrives.
#pragma once

#include <memory>

#include "slave/reference/planar/patch_solution.h"
#include "slave/reference/planar/round_touch.h"
#include "slave/simulator/environment/solved_ahead.h"

namespace palpate::simulation {

// Solves contacts in advance: while the tool approaches, a separate thread computes the solution
// for the expected contact point, so that the start of contact is not delayed.
class SolutionsAhead {
 public:
  // `body` must outlive this. `tilts`: the tool may be rotated, so its contact changes like that of
  // a round one. A tool that reaches through a part of `thickness` [m] presses a solid block, any
  // other one a plane body.
  SolutionsAhead(const TrueBody& body, double poisson_ratio, Plane plane, const Tool& tool,
                 bool tilts, double thickness);

  // Requests a solution near `place`. Returns at once; the newest request counts.
  void Expect(const BoundaryPlace& place) { (void)Wanted(place); }
  // Returns the solution nearest to `place` on the raster of contact points; waits for it if
  // necessary (10 to 40 ms). nullptr: it could not be solved.
  std::shared_ptr<const PatchSolution> Await(const BoundaryPlace& place);

 private:
  struct Contact : ContactAhead {
    const SolutionsAhead& of;
    int loop;
    long multiple;  // of the raster, along the loop
    std::shared_ptr<const PatchSolution> solution;

    [[nodiscard]] std::shared_ptr<const PatchSolution> Solve() const noexcept;
    void Add(std::shared_ptr<const PatchSolution> solved);
  };
  std::shared_ptr<Contact> Wanted(const BoundaryPlace& place);

  const TrueBody& body_;
  double poisson_ratio_;
  Plane plane_;
  Tool tool_;
  bool tilts_;
  double thickness_;               // of a solid; 0: plane [m]
  double raster_;                  // [m]
  SolvedAhead<Contact> contacts_;  // last: its thread uses everything above
};

}  // namespace palpate::simulation
