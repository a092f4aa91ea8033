// How the membrane lies under the tool now, from presses that were solved at some radii only.
#pragma once

#include <array>
#include <memory>

#include <Eigen/Core>

#include "slave/site/points/membrane/pressed_membrane.h"

namespace palpate::site {

// A round membrane is the same all around: presses are solved on the x axis and turned to where the
// tool is. Between two solved radii forces and displacements are blended, each field carried
// there first by the map of the disc onto itself that takes its tool's place to the true one
//
//   z -> (z - m) / (1 - m z),   m = (p - q) / (1 - p q),   p -> q, the rim stays the rim,
//
// which for a tight membrane under a small load is no approximation (Laplace's equation keeps its
// form under conformal maps). Frame O.
struct Dent {
  struct Part {
    std::shared_ptr<const MembranePress> press;
    double radius = 0;  // of the place at which it was solved [m]
    double share = 0;   // of the blend; the shares' sum is 1
  };
  double rim = 0;                 // radius of the membrane [m]
  Eigen::Vector2d place_O{0, 0};  // of the tool's axis [m]
  double depth = 0;               // of the tool's tip below the rest plane [m]
  std::array<Part, 2> parts;      // without presses: nothing touches
};

// Of the tool on the membrane along z [N]: negative presses.
double ForceOf(const Dent& dent) noexcept;
// Of the inner face's point that rests at p_O [m].
Eigen::Vector3d DisplacementOf(const Dent& dent, const Eigen::Vector2d& p_O) noexcept;

}  // namespace palpate::site
