// A contact solved in advance in steps: loads of fingers and body at increasing depths of one
// approach, with interpolation in between.
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
#include "slave/simulator/fingertips/pressed_body.h"
#include "slave/simulator/fingertips/true_object.h"

namespace palpate::site {

// One step of a ladder. Immutable once made.
struct LoadStep {
  double s = 0;  // motion along the approach [m]
  std::array<FingerTouch, kMaxFingers> touches{};
  std::vector<Eigen::Vector3f> displacements_O;  // of all nodes [m]
};
using Rungs = std::vector<std::shared_ptr<const LoadStep>>;  // s rising

// Interpolated load of one finger at `s`: forces by monotone cubics between steps (Fritsch and
// Carlson 1980), the rest linear. No contact before the first step; beyond the last one, force and
// depth are extrapolated from the last two. `slope`: d |force| / d s [N/m].
struct TouchBetween {
  FingerTouch touch;
  double slope = 0;
};
TouchBetween TouchAt(const Rungs& rungs, int finger, double s) noexcept;

// Of every node, linear between rungs, zero before the first; beyond the last one as at it.
void DisplacementsAt(const Rungs& rungs, double s, std::vector<Eigen::Vector3d>* displacement_O);

// Solves contacts in advance: a separate thread computes the steps for the present position, one by
// one, so that a contact only reads them. Known contacts at one position. Steps and body belong
// together.
struct SolvedPress {
  std::shared_ptr<const RestBody> body;
  std::shared_ptr<const Rungs> rungs = std::make_shared<Rungs>();
};

class LoadPathCache {
 public:
  // Positions beside the approach, in multiples of the raster: positions nearer than half of it
  // share the steps.
  using Key = std::pair<int, int>;
  static constexpr double kRaster = 5e-3;  // [m]

  // The object must outlive this. `deepest` [m]: largest depth beyond the first contact.
  LoadPathCache(const TrueObject& object, double deepest);
  ~LoadPathCache();

  [[nodiscard]] Key KeyOf(const Eigen::Vector3d& h_O) const;
  // Requests a contact here: the newest request is processed. Returns the motion along the approach
  // until the first finger touches; infinity: none does. Milliseconds for a new position, else
  // short.
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
