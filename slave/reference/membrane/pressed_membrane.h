// PressedMembrane solves a clamped rubber membrane under a flat round tool as a hyperelastic solid,
// at rising depths of one press.
//
// The membrane is a thick plate of neo-Hookean rubber in three dimensions (neo_hookean_disc.h), on
// cubic hexahedra fitted to the tool (DiscMesh): without plate theory or modes. The tool always
// presses along -z. A rigid face does not tilt and is not glued: nodes of the outer face below it
// are at its depth and pushed, or deeper and free. A uniform load is spread over its face, and its
// depth is the displacement of the outer face below its centre. So force and depth have the same
// meaning as in the plate models.
//
// With default options the mesh error is 0.1 % of the force and of the depth for the field (0.2 %
// beyond half the radius, below wide tools, in sheets of a / 20), and a press of 0 to 5 mm on the
// paper's membrane takes a second or two.
#pragma once

#include <array>
#include <cstdint>
#include <memory>
#include <vector>

#include <Eigen/Core>

#include "slave/reference/membrane/membrane_face.h"
#include "slave/scene/scene.h"

namespace palpate::simulation {

// The membrane under the tool at one depth. Frame O; immutable after construction.
struct MembraneDepthStep {
  double depth = 0;  // displacement of the tool since the first touch, along -z [m]
  double force = 0;  // of the tool on the membrane along z [N]: negative pushes
  std::vector<Eigen::Vector3f> displacements_O;  // of the inner face's nodes [m]
};

// A contact at one position, as far as it is solved.
struct MembranePress {
  std::vector<Eigen::Vector2d> nodes_O;       // of the inner face (towards -z), at rest [m]
  std::vector<std::array<int, 3>> triangles;  // of the inner face
  std::vector<std::shared_ptr<const MembraneDepthStep>> depth_steps;  // depths rising, from zero
  std::shared_ptr<const MembraneFace> face;  // interpolates between the nodes
};

// Force along z [N] at `depth` by monotone cubics between steps; beyond the last one extrapolated
// from the last two. Zero at depth <= 0.
double ForceAt(const MembranePress& press, double depth) noexcept;
// Displacement of the inner face's point that rests at p_O [m], frame O, at `depth`: by cubics
// between depth steps, of the mesh's own order in space; beyond the last depth step as at it. Zero
// outside the rim.
Eigen::Vector3d DisplacementAt(const MembranePress& press, const Eigen::Vector2d& p_O,
                               double depth) noexcept;

struct MembraneResolution {
  // Elements from the centre to the rim, one more for a wide tool; 0: as many as the stated
  // accuracy needs.
  int across = 0;
  int through = 0;  // layers through the thickness; 0: as above
};

// How a flat round tool presses: as a rigid face that may touch with a part of it, or as a uniform
// load.
enum class ToolFace : std::uint8_t { kEven, kRigid };
constexpr ToolFace FaceOf(const Tool& tool) {
  return tool.IsRigidFace() ? ToolFace::kRigid : ToolFace::kEven;
}

// Solves a contact of a flat round tool of diameter `width` [m] at p_O with increasing depth.
class PressedMembrane {
 public:
  // `prestress`: tension at rest [N/m], from a stretch of the sheet to the geometry's radius and
  // thickness. Throws std::invalid_argument naming the key: no membrane, a position whose tool does
  // not fit inside the rim, numbers out of range. nu beyond 0.499 is replaced by it: its force is
  // low by less than 0.2 %.
  PressedMembrane(const MembraneGeometry& geometry, const Material& material, double width,
                  const Eigen::Vector2d& p_O, const MembraneResolution& resolution = {},
                  double prestress = 0, ToolFace face = ToolFace::kEven);
  ~PressedMembrane();

  // Solves the next step at `depth`, deeper than the last one. False: no equilibrium was found, or
  // the depth is beyond half the radius; the contact is unchanged.
  bool Deepen(double depth);
  [[nodiscard]] const MembranePress& press() const;

 private:
  struct Continuation;
  std::unique_ptr<Continuation> continuation_;
};

// The present shape of the membrane under the tool, from presses that were solved at some radii
// only. By symmetry presses are solved on the x axis and rotated to the tool's position. Between
// two solved radii forces and displacements are interpolated. Each field is first transformed by
// the conformal map of the disc onto itself that moves its tool position to the true one
//
//   z -> (z - m) / (1 - m z),   m = (p - q) / (1 - p q),   p -> q, the rim stays the rim,
//
// which for a tight membrane under a small load is no approximation (Laplace's equation keeps its
// form under conformal maps). Frame O.
struct Indentation {
  struct Part {
    std::shared_ptr<const MembranePress> press;
    double radius = 0;  // of the position at which it was solved [m]
    double share = 0;   // of the blend; the shares' sum is 1
  };
  double rim = 0;                 // radius of the membrane [m]
  Eigen::Vector2d place_O{0, 0};  // of the tool's axis [m]
  double depth = 0;               // of the tool's tip below the rest plane [m]
  std::array<Part, 2> parts;      // without contacts: a free membrane
};

// Force of the tool on the membrane along z [N]: negative pushes.
double ForceOf(const Indentation& indentation) noexcept;
// Displacement of the inner face's point that rests at p_O [m].
Eigen::Vector3d DisplacementOf(const Indentation& indentation, const Eigen::Vector2d& p_O) noexcept;

}  // namespace palpate::simulation
