// Presses of a membrane at a raster of radii, solved in advance: around the tool, and everywhere
// else on request.
//
// At the home radius presses are solved on the default mesh of PressedMembrane, elsewhere on one
// that takes half the time and has errors of 0.2 % of the force and 10 um of the field.
#pragma once

#include <array>
#include <atomic>
#include <cstddef>
#include <memory>
#include <vector>

#include "slave/reference/membrane/pressed_membrane.h"
#include "slave/scene/scene.h"
#include "slave/simulator/environment/solved_ahead.h"

namespace palpate::simulation {

class PressCache {
 public:
  struct Plan {
    MembraneGeometry geometry;
    Material material;
    double width = 0;  // of the tool [m]
    ToolFace face = ToolFace::kEven;
    double home_radius = 0;  // one of the radii at which contacts are solved [m]
    double press_depth = 0;  // the distance of depth steps is a fifth of it, at first smaller [m]
    double prestress = 0;    // tension at rest [N/m]
    MembraneResolution resolution;
  };
  static constexpr double kDeeper = 1.6;     // steps reach this number of press depths,
  static constexpr double kDeepest = 0.5;    // largest depth relative to the radius
  static constexpr double kMaxPlace = 0.75;  // radii of contacts, relative to that of the membrane
  static constexpr double kRaster = 1.0 / 13;  // between them, the same

  // The first contact is created here, its steps follow in the thread. Throws std::invalid_argument
  // like PressedMembrane.
  explicit PressCache(const Plan& plan);

  // The largest radius at which contacts are solved [m].
  [[nodiscard]] double farthest() const { return all_series_.back()->radius; }
  // Requests a contact at `radius` (0 to farthest()). Short.
  void Expect(double radius);
  // From now on contacts are solved at all radii, those nearest to the tool first; by a thread with
  // a low priority.
  void SolveEverywhere();

  struct Presses {
    std::array<Indentation::Part, 2> parts;
    bool solved = true;  // false: not those around the radius, as deep as they can be
  };
  // The contacts around `radius`, at least as deep as `depth`; waits for them if necessary. Less
  // deep if no equilibrium was found or the steps end.
  Presses Await(double radius, double depth);
  // Does not wait. Until the contacts around `radius` are solved, returns the nearest ones on
  // either side that are deep enough, or only that of one side; if no contact is deep enough, the
  // deepest of all.
  Presses Find(double radius, double depth);

 private:
  using Press = std::shared_ptr<const MembranePress>;
  struct DepthSeries : ContactAhead {
    DepthSeries(const PressCache& cache, double at) : of(cache), radius(at) {}
    Press Solve() noexcept;
    void Add(Press deeper);
    // These need the lock:
    [[nodiscard]] double depth() const {
      return press->depth_steps.empty() ? 0 : press->depth_steps.back()->depth;
    }
    [[nodiscard]] bool Reaches(double depth) const;

    const PressCache& of;
    const double radius;
    Press press = std::make_shared<MembranePress>();  // the part that is solved so far
    std::unique_ptr<PressedMembrane> membrane;        // while it grows; the thread's only
    std::atomic<bool> missed = false;  // a contact was requested here before it was solved
    bool announced = false;  // its solution was announced in the log; used by the thread only
  };
  struct Around {
    std::size_t below = 0, above = 0;
  };

  [[nodiscard]] std::unique_ptr<PressedMembrane> Make(double radius) const;
  [[nodiscard]] std::vector<std::shared_ptr<DepthSeries>> MakeAllSeries() const;
  [[nodiscard]] Around FindAround(double radius) const;
  [[nodiscard]] static Presses Between(const DepthSeries& below, const DepthSeries& above,
                                       double radius);
  // These need the lock:
  [[nodiscard]] Presses Nearest(const Around& around, double radius, double depth) const;
  [[nodiscard]] std::shared_ptr<DepthSeries> Next();

  const Plan plan_;
  const std::vector<double> depths_;                      // of the depth steps beyond zero, rising
  std::vector<std::shared_ptr<DepthSeries>> all_series_;  // radii rising; which ones never changes
  // These need the lock:
  double focus_;  // requested radius
  bool everywhere_ = false, is_nice_ = false;
  SolvedAhead<DepthSeries> solved_;  // last: its thread uses everything above
};

}  // namespace palpate::simulation
