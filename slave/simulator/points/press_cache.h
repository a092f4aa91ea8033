// Solves presses before they happen: a thread of its own works out, rung by rung, what the tool
// will do near where it is, and everywhere else when asked to, so that a press only reads it.
//
// At home's radius presses are solved on PressedMembrane's own mesh, elsewhere on one that takes
// half the time and is good for 0.2 % of the force and 10 um of the field.
#pragma once

#include <array>
#include <atomic>
#include <condition_variable>
#include <cstddef>
#include <cstdint>
#include <memory>
#include <mutex>
#include <thread>
#include <vector>

#include "slave/reference/membrane/pressed_membrane.h"
#include "slave/scene/scene.h"

namespace palpate::site {

class PressCache {
 public:
  struct Plan {
    MembraneGeometry geometry;
    Material material;
    double width = 0;        // of the tool [m]
    double home_radius = 0;  // one of the radii at which contacts are solved [m]
    double press_depth = 0;  // steps are a fifth of it apart, finer at first [m]
    double prestress = 0;    // tension at rest [N/m]
    MembraneResolution resolution;
  };
  static constexpr double kDeeper = 1.6;     // steps reach this number of press depths,
  static constexpr double kDeepest = 0.5;    // but not deeper than this part of the radius
  static constexpr double kFarthest = 0.75;  // radii of contacts, relative to that of the membrane
  static constexpr double kRaster = 1.0 / 13;  // between them, the same

  // The first contact is created here, its steps follow in the thread. Throws std::invalid_argument
  // as PressedMembrane does.
  explicit PressCache(const Plan& plan);
  ~PressCache();

  // The largest radius at which contacts are solved [m].
  [[nodiscard]] double farthest() const { return ladders_.back()->radius; }
  // Requests a contact at `radius` (0 to farthest()). Short.
  void Expect(double radius);
  // From now on contacts are solved at all radii, those nearest to home first, except under the
  // tool; by a thread with the lowest priority.
  void SolveEverywhere();
  [[nodiscard]] bool is_solved_everywhere() const;

  struct Presses {
    std::array<Dent::Part, 2> parts;
    bool solved = true;  // false: not those around the radius, as deep as they can be
  };
  // The contacts around `radius`, at least as deep as `depth`; waits for them if necessary. Less
  // deep if no equilibrium was found or the steps end.
  Presses Await(double radius, double depth);
  // Short: until those are solved, the nearest ones on either side that are deep enough; on one
  // side only where there are none on the other; the deepest of all if none is deep enough.
  Presses Find(double radius, double depth);
  // How often Await() had to wait.
  [[nodiscard]] std::uint64_t waits() const { return waits_; }

 private:
  struct Ladder {
    double radius = 0;
    std::shared_ptr<const MembranePress> press;  // as far as it is solved
    std::unique_ptr<PressedMembrane> membrane;   // while it grows; the thread's only
    bool complete = false;
    bool missed = false;     // a contact was requested here before it was solved
    bool announced = false;  // that it is being solved; the thread's only
  };
  struct Around {
    std::size_t below = 0, above = 0;
  };

  [[nodiscard]] Around FindAround(double radius) const;
  [[nodiscard]] Presses Between(const Ladder& below, const Ladder& above, double radius) const;
  // With mutex_ held:
  [[nodiscard]] bool Reaches(const Ladder& ladder, double depth) const;
  [[nodiscard]] Presses Nearest(const Around& around, double radius, double depth) const;
  [[nodiscard]] Ladder* Next() const;

  [[nodiscard]] std::unique_ptr<PressedMembrane> Make(double radius) const;
  std::shared_ptr<const MembranePress> Grow(Ladder* ladder) const noexcept;
  static void Announce(const Ladder& ladder);
  void Run(const std::stop_token& stop);

  Plan plan_;
  std::vector<double> depths_;  // of the rungs beyond zero, rising

  std::atomic<std::uint64_t> waits_{0};

  mutable std::mutex mutex_;  // guards what follows
  std::condition_variable_any changed_;
  std::vector<std::unique_ptr<Ladder>> ladders_;  // radii rising; they themselves never change
  double focus_ = 0;                              // requested radius
  bool everywhere_ = false;
  std::jthread thread_;  // last: it uses everything above
};

}  // namespace palpate::site
