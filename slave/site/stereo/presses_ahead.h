// Solves presses before they happen: a thread of its own works out, rung by rung, what the tool
// will do near where it is, so that a press only reads it.
#pragma once

#include <array>
#include <condition_variable>
#include <cstddef>
#include <memory>
#include <mutex>
#include <thread>
#include <vector>

#include "shared/scene/scene.h"
#include "slave/site/stereo/dent.h"
#include "slave/site/stereo/pressed_membrane.h"

namespace palpate::site {

class PressesAhead {
 public:
  struct Plan {
    MembraneGeometry geometry;
    Material material;
    double width = 0;        // of the tool [m]
    double home_radius = 0;  // one of the radii at which presses are solved [m]
    double press_depth = 0;  // rungs are a tenth of it apart, finer at first [m]
    double prestress = 0;    // tension at rest [N/m]
    MembraneResolution resolution;
  };
  static constexpr double kDeeper = 1.6;       // rungs go so many press depths deep,
  static constexpr double kDeepest = 0.5;      // but not deeper than this part of the radius
  static constexpr double kFarthest = 0.75;    // radii of presses, in those of the membrane
  static constexpr double kRaster = 1.0 / 13;  // between them, likewise

  // The first press is made here, the rungs follow in the thread. Throws std::invalid_argument as
  // PressedMembrane does.
  explicit PressesAhead(const Plan& plan);
  ~PressesAhead();

  // The largest radius at which presses are solved [m].
  [[nodiscard]] double farthest() const { return ladders_.back()->radius; }
  // A press at `radius` (0 to farthest()) is to be expected. Short.
  void Expect(double radius);
  // The presses around `radius`, as deep as `depth` at least, waiting for them if need be; less
  // deep where no equilibrium was found or the ladder ends.
  std::array<Dent::Part, 2> Await(double radius, double depth);

 private:
  struct Ladder {
    double radius = 0;
    std::shared_ptr<const MembranePress> press;  // as far as it is solved
    std::unique_ptr<PressedMembrane> membrane;   // while it grows; the thread's only
    bool complete = false;
  };
  struct Around {
    std::size_t below = 0, above = 0;
    double part = 0;  // of the way from `below` to `above`
  };

  [[nodiscard]] Around Find(double radius) const;
  [[nodiscard]] bool Reaches(const Ladder& ladder, double depth) const;  // with mutex_ held
  [[nodiscard]] Ladder* Next() const;                                    // with mutex_ held
  [[nodiscard]] std::unique_ptr<PressedMembrane> Make(double radius) const;
  std::shared_ptr<const MembranePress> Grow(Ladder* ladder) const noexcept;
  void Run(const std::stop_token& stop);

  Plan plan_;
  std::vector<double> depths_;  // of the rungs beyond zero, rising

  std::mutex mutex_;  // guards what follows
  std::condition_variable_any changed_;
  std::vector<std::unique_ptr<Ladder>> ladders_;  // radii rising; they themselves never change
  double focus_ = 0;                              // radius that is wanted
  std::jthread thread_;                           // last: it uses everything above
};

}  // namespace palpate::site
