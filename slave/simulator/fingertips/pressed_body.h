// A soft body of neo-Hookean rubber (site/solid) between rigid fingertips.
//
// A node of the surface that a finger meets sticks to it (no slip) until the finger would have to
// pull it. Force = reaction. Newton's method finds the equilibrium.
#pragma once

#include <array>
#include <functional>
#include <memory>
#include <span>
#include <vector>

#include <Eigen/Core>
#include <Eigen/Geometry>

#include "slave/simulator/fingertips/site_mesh.h"

namespace palpate::simulation {

// Pose of a finger and its direction of motion.
struct FingerPlacement {
  Eigen::Isometry3d X_OF = Eigen::Isometry3d::Identity();
  Eigen::Vector3d approach_O{0, 0, 0};  // unit vector of its motion; zero: stationary
};

// Contact of one finger with the body. Frame O.
struct FingerTouch {
  bool touching = false;
  Eigen::Vector3d force_O{0, 0, 0};  // of the finger on the body [N]
  Eigen::Vector3d p_F{0, 0, 0};      // centre of pressure on the finger's surface [m]
  double radius = 0;                 // of the disc with a sphere's pressure that spreads as far [m]
  double depth = 0;                  // largest displacement of a touched node [m]
};

class PressedBody {
 public:
  using Held = std::vector<std::array<bool, 3>>;  // fixed components, per node

  // Young's modulus at a point of frame O, divided by `young_modulus` [-]; empty: 1.
  using Modulus = std::function<double(const Eigen::Vector3d&)>;

  // Throws std::invalid_argument: an element without volume, no element.
  PressedBody(const SiteMesh& mesh, const Held& held, double young_modulus, double poisson_ratio,
              double finger_radius, const Modulus& modulus = {});
  ~PressedBody();

  // Moves the fingers from where they were. False: no equilibrium was found; the body is as it was.
  bool Press(std::span<const FingerPlacement> fingers);

  [[nodiscard]] FingerTouch TouchOf(int finger) const;
  // Displacements of all nodes of the mesh, frame O [m].
  [[nodiscard]] std::vector<Eigen::Vector3d> Displacements() const;

 private:
  struct Solver;
  std::unique_ptr<Solver> solver_;
};

}  // namespace palpate::simulation
