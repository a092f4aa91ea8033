// A press solved in steps ahead of time: what fingers and body do at rising depths of one approach,
// and in between by interpolation.
#pragma once

#include <array>
#include <memory>
#include <vector>

#include <Eigen/Core>

#include "shared/state/slave_state.h"
#include "slave/site/fingertips/pressed_body.h"

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

}  // namespace palpate::site
