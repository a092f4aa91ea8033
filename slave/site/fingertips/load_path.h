// A press solved in steps ahead of time: what fingers and body do at rising depths of one approach,
// and in between by interpolation.
#pragma once

#include <array>
#include <condition_variable>
#include <deque>
#include <memory>
#include <mutex>
#include <thread>
#include <utility>
#include <vector>

#include <Eigen/Core>

#include "shared/state/slave_state.h"
#include "slave/site/fingertips/pressed_body.h"
#include "slave/site/fingertips/true_object.h"

namespace palpate::site {

// One step of a ladder. Immutable once made.
struct LoadStep {
  double s = 0;  // way of the hand along its approach [m]
  std::array<FingerTouch, kMaxFingers> touches{};
  std::vector<Eigen::Vector3f> displacements_O;  // of all nodes [m]
};
using Rungs = std::vector<std::shared_ptr<const LoadStep>>;  // s rising

// What the rungs say of one finger at `s`: forces by monotone cubics between rungs (Fritsch and
// Carlson 1980), the rest linear. Nothing touches before the first rung; beyond the last one, force
// and depth go on as between the last two. `slope`: d |force| / d s [N/m].
struct TouchBetween {
  FingerTouch touch;
  double slope = 0;
};
TouchBetween TouchAt(const Rungs& rungs, int finger, double s) noexcept;

// Of every node, linear between rungs, zero before the first; beyond the last one as at it.
void DisplacementsAt(const Rungs& rungs, double s, std::vector<Eigen::Vector3d>* displacement_O);

// Solves presses before they happen: a thread of its own works out the ladder for the place that
// the hand is over, step by step, so that a press only reads it.
// What is known of presses at one place so far. Rungs and body belong together.
struct SolvedPress {
  std::shared_ptr<const RestBody> body;
  std::shared_ptr<const Rungs> rungs = std::make_shared<Rungs>();
};

class LoadPathCache {
 public:
  // Places beside the approach, in multiples of the raster: hands nearer than half of it share a
  // ladder.
  using Key = std::pair<int, int>;
  static constexpr double kRaster = 5e-3;  // [m]

  // The object must outlive this. `deepest` [m]: how far beyond the first touch a ladder goes.
  LoadPathCache(const TrueObject& object, double deepest);
  ~LoadPathCache();

  [[nodiscard]] Key KeyOf(const Eigen::Vector3d& h_O) const;
  // A press here is to be expected: the newest wish is worked on. The way along the approach at
  // which the first finger touches; infinity: none does. Milliseconds for a new place, else short.
  double Expect(const Key& key);
  // The ladder here, as far as way `s` at least if there is one so far, waiting for it if need be
  // (a third of a second or so per millimetre of depth). May be shorter where no equilibrium was
  // found.
  SolvedPress Await(const Key& key, double s);

 private:
  struct Ladder {
    Key key;
    std::vector<double> ways;  // of the rungs, rising
    SolvedPress solved;
    std::unique_ptr<PressedBody> body;  // while it grows; the thread's only
    bool complete = false;
  };

  [[nodiscard]] Eigen::Vector3d LateralOf(const Key& key) const;
  [[nodiscard]] std::vector<double> WaysOf(const Key& key, const RestBody& body) const;
  [[nodiscard]] std::shared_ptr<Ladder> Find(const Key& key) const;  // with mutex_ held
  std::shared_ptr<Ladder> Wanted(const Key& key);                    // with mutex_ held
  [[nodiscard]] std::shared_ptr<Ladder> Next() const;                // with mutex_ held
  std::shared_ptr<const LoadStep> Grow(Ladder* ladder, std::size_t rung) const noexcept;
  bool Press(const Ladder& ladder, double from, double to, int halvings) const;
  void Run(const std::stop_token& stop);

  const TrueObject& object_;
  double deepest_;
  std::array<Eigen::Vector3d, 2> beside_O_;  // unit vectors across the approach

  std::mutex mutex_;  // guards what follows
  std::condition_variable_any changed_;
  std::deque<std::shared_ptr<Ladder>> ladders_;  // the newest wish first
  std::jthread thread_;                          // last: it uses everything above
};

}  // namespace palpate::site
