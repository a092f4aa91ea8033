// The tool meets the boundary (paper A, 3.5): an OBB tree finds where the tip's path crosses, a
// neighbourhood watch follows the place while in contact. Planar; frame O [m].
#pragma once

#include <memory>

#include <Eigen/Core>

#include "shared/mesh/outline.h"

namespace palpate {

// A place on the boundary at rest: the ideal haptic interface point.
struct BoundaryPlace {
  int element = -1;                // index into the mesh; -1: none
  double s = 0;                    // along the element [0, 1] from a to b
  Eigen::Vector2d p_O{0, 0};       // the place [m]
  Eigen::Vector2d normal_O{0, 1};  // outward unit normal [-]
  double gap = 0;  // signed distance of the tip along the normal [m]; negative: inside
};

// One tool tip's contact with one boundary.
class BoundaryContact {
 public:
  // Keeps its own copy of what it needs. Throws std::invalid_argument: fewer than three elements.
  explicit BoundaryContact(const BoundaryMesh& mesh);
  ~BoundaryContact();

  // Moves the tip to `p_O_tip` and returns the place it touches, or the nearest one while out of
  // contact. Contact begins where the path from the last tip crosses the boundary inwards and
  // sticks to that place (bonded) until the tip comes out again through the place's plane. The
  // first call only sets the tip; a first tip already inside counts as contact at the nearest
  // place. Not finite: nothing changes. No allocation.
  const BoundaryPlace& MoveTip(const Eigen::Vector2d& p_O_tip) noexcept;
  [[nodiscard]] bool in_contact() const;
  // Forget the tip and the contact.
  void Reset() noexcept;

 private:
  struct Parts;
  std::unique_ptr<Parts> parts_;
};

}  // namespace palpate
