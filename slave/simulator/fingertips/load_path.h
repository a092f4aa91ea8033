// A contact solved in advance in steps: loads of fingers and body at increasing depths of one
// approach, with interpolation in between.
#pragma once

#include <array>
#include <deque>
#include <memory>
#include <utility>
#include <vector>

#include <Eigen/Core>

#include "shared/state/slave_state.h"
#include "slave/simulator/environment/solved_ahead.h"
#include "slave/simulator/fingertips/pressed_body.h"
#include "slave/simulator/fingertips/true_object.h"

namespace palpate::simulation {

// One step of a series. Immutable after construction.
struct LoadStep {
  double s = 0;  // motion along the approach [m]
  std::array<FingerTouch, kMaxFingers> touches{};
  std::vector<Eigen::Vector3f> displacements_O;  // of all nodes [m]
};
using DepthSteps = std::vector<std::shared_ptr<const LoadStep>>;  // s rising

// Interpolated load of one finger at `s`: forces by monotone cubics between steps (Fritsch and
// Carlson 1980), the rest linear. No contact before the first step; beyond the last one, force and
// depth are extrapolated from the last two. `slope`: d |force| / d s [N/m].
struct TouchBetween {
  FingerTouch touch;
  double slope = 0;
};
TouchBetween TouchAt(const DepthSteps& depth_steps, int finger, double s) noexcept;

// Displacement of every node, linear between depth steps, zero before the first; beyond the last
// one as at it.
void DisplacementsAt(const DepthSteps& depth_steps, double s,
                     std::vector<Eigen::Vector3d>* displacement_O);

// Known contacts at one position. Steps and body belong together.
struct SolvedPress {
  std::shared_ptr<const RestBody> body;
  std::shared_ptr<const DepthSteps> depth_steps = std::make_shared<DepthSteps>();
  double s = 0;        // distance along the approach [m]
  bool solved = true;  // false: steps of another position or depth, because this one is not solved
};

// Solves contacts in advance: a separate thread computes the steps for the present position, one by
// one, so that a contact only reads them.
class LoadPathCache {
 public:
  // Position across the approach, in multiples of the raster. Positions nearer than half a raster
  // share the steps.
  using Key = std::pair<int, int>;
  static constexpr double kRaster = 5e-3;  // [m]

  // The object must outlive this. `deepest` [m]: largest depth beyond the first contact.
  LoadPathCache(const TrueObject& object, double deepest);

  [[nodiscard]] Key KeyOf(const Eigen::Vector3d& h_O) const;
  // Requests a contact at `key`; the newest request is processed. Returns the motion along the
  // approach until the first finger touches, infinity if none does. At a new position it waits for
  // tens of milliseconds.
  double Expect(const Key& key);
  // As Expect without waiting: at a new position it returns the value of the nearest known one.
  double ExpectNow(const Key& key);
  // Returns the steps at `key` up to depth `s` [m] or more. It waits for them, about a third of a
  // second per millimetre. The steps end earlier where no equilibrium was found.
  SolvedPress Await(const Key& key, double s);
  // As Await without waiting. For an unsolved position it returns the steps of the nearest solved
  // one at the same depth beyond the first contact, else those of the deepest one.
  SolvedPress Find(const Key& key, double s);

 private:
  // The first step of a series determines body and distances, the others add depth steps; neither:
  // the body cannot be pressed deeper.
  struct Step {
    std::shared_ptr<const RestBody> body;
    std::vector<double> ways;
    std::shared_ptr<const LoadStep> depth_step;
  };
  struct DepthSeries : ContactAhead {
    DepthSeries(const LoadPathCache& cache, const Key& place);
    [[nodiscard]] Step Solve() noexcept;
    void Add(const Step& step);
    [[nodiscard]] Step SolveDepthStep();
    bool Press(double from, double to, int halvings);
    // Returns whether one depth step beyond `s` is solved: the cubics use it, and answers must not
    // depend on the progress of the thread.
    [[nodiscard]] bool Reaches(double s) const;
    // Returns the solved depth beyond the first contact [m]; -1: none.
    [[nodiscard]] double depth() const;
    [[nodiscard]] SolvedPress At(double s, bool is_solved) const;
    // Returns whether body and distances are known.
    [[nodiscard]] bool is_known() const { return solved.body != nullptr; }
    // Distance to the first contact [m]; infinity: there is none, or it is unknown.
    [[nodiscard]] double first() const;

    const LoadPathCache& of;
    const TrueObject& object;
    Key key;
    Eigen::Vector3d lateral_O;
    SolvedPress solved;
    std::vector<double> ways;           // of the depth steps, rising
    std::unique_ptr<PressedBody> body;  // the thread's only
  };
  [[nodiscard]] std::vector<double> WaysOf(const Eigen::Vector3d& lateral_O,
                                           const RestBody& body) const;
  std::shared_ptr<DepthSeries> Wanted(const Key& key);
  static double Distance(const DepthSeries& series, const Key& key);
  // Returns `wanted`, or the nearest of `all_series` whose body is known.
  static const DepthSeries& Known(const DepthSeries& wanted,
                                  const std::deque<std::shared_ptr<DepthSeries>>& all_series);

  const TrueObject& object_;
  double deepest_;
  std::array<Eigen::Vector3d, 2> beside_O_;  // unit vectors across the approach
  SolvedAhead<DepthSeries> all_series_;      // last: its thread uses everything above
};

}  // namespace palpate::simulation
