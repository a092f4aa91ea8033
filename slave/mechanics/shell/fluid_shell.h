// A thin spherical shell filled with a liquid that does not give way, pressed at its pole by a
// rigid disc and fixed by a cap on the other side: what an egg is, where a solid disc of the same
// modulus bounds its stiffness from above.
//
// The shell of wall h stretches and bends, by as much as it likes, and stays a surface of
// revolution. Of its meridian (r, z), cut into straight pieces, the energy
//
//   W = int E h / (2 (1 - nu^2)) (e1^2 + 2 nu e1 e2 + e2^2) dA        e: stretches less one
//     + int E h^3 / (24 (1 - nu^2)) (k1^2 + 2 nu k1 k2 + k2^2) dA     k: changes of curvature
//
// is least under V = V0, the liquid's volume, whose multiplier is the liquid's pressure. Tool and
// holder are bonded: under them the wall stays as it is. Source: Reissner, "On axisymmetrical
// deformations of thin shells of revolution", Proc. Symp. Appl. Math. 3 (1950).
//
// What it is not: a wall folds before it bears much compression along its parallels, which a
// surface of revolution cannot; then the shell is softer.
#pragma once

#include <vector>

#include <Eigen/Core>

#include "slave/mechanics/shell/meridian_energy.h"

namespace palpate {

class FluidShell {
 public:
  struct Params {
    double radius = 0;         // R [m], > 0
    double wall = 0;           // h [m], 0 < h <= R / 20
    double young_modulus = 0;  // E [Pa], > 0
    double poisson_ratio = 0;  // nu [-], -1 < nu <= 0.5
    double tool_radius = 0;    // of the disc [m], 0 < tool_radius <= R / 2
    double held_angle = 0;     // half angle of the fixed cap from the centre [rad], 0.05 to 2
    int pieces = 320;          // of the meridian, 20 to 4000
    bool filled = true;        // false: empty, the volume is free
  };
  // From the tool's edge to the holder's, (r, z) [m]: r from the axis, the pole rests at z = R.
  using Meridian = std::vector<Eigen::Vector2d>;
  struct State {
    double depth = 0;     // [m]
    double force = 0;     // of the tool on the shell, inwards [N]
    double pressure = 0;  // of the liquid above that outside [Pa]
    Meridian meridian;
  };

  // Throws std::invalid_argument naming the parameter, its value and what is accepted.
  explicit FluidShell(const Params& params);

  // Moves from the last depth to `depth` [m], >= 0, in as many steps as needed. False: no
  // equilibrium is found on the way; the state is the last equilibrium.
  bool PressTo(double depth);
  [[nodiscard]] const State& state() const { return state_; }
  // Within the free part of the wall, now [m^3].
  [[nodiscard]] double Volume() const;

 private:
  using Points = std::vector<Eigen::Vector2d>;
  struct System;  // gradient and Hessian of all unknowns

  void LayOut();
  [[nodiscard]] Points At(const Eigen::VectorXd& x, double depth) const;
  void Assemble(const Points& points, double pressure, System* system) const;
  bool Solve(double depth);
  void UpdateState(double depth);

  Params params_;
  double thin_ = 0;  // h / R
  // In parts of R. The first and the last node lie on tool and holder, beyond the edges.
  Points rest_;
  std::vector<shell::Piece> pieces_;  // piece i: from node i to i + 1
  std::vector<shell::Hinge> hinges_;  // hinge i: at node i + 1
  double volume_ = 0;                 // at rest
  Eigen::VectorXd x_;                 // of the free nodes, then the pressure
  State state_;
};

}  // namespace palpate
