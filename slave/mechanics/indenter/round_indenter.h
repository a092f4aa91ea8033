// A rigid round tool pressed into a body: its contact grows with the depth, as Hertz has it for
// bodies much larger than the contact.
//
// The tool is a cylinder across the plane in 2D and a sphere in 3D. Of its axis, along the outward
// normal n, every place x of the boundary at rest lies at a distance rho; were it to pass through
// the body, the tool would be there by
//
//   delta = n . (x - p) - n . u - (R - sqrt(R^2 - rho^2))
//
// too deep, p where it touched first, u how far it has moved since: along n its centre, across n
// the point of the tool that touched first, from which a tool that turns rolls away. Places with
// delta > 0 may touch: they are moved by u_t - delta n (u_t: u across n), the others are free. What
// would be pulled lets go, until all that touch are pushed: a linear complementarity problem. Where
// the stiffness has no positive entry off its diagonal, what lets go never comes back
// (Chandrasekaran, Opsearch 7, 1970); a body that bends may press places against the tool again, so
// those that let go are examined once more. Works on any DeformationModel that moves single places.
#pragma once

#include <span>
#include <vector>

#include <Eigen/Core>

#include "shared/mesh/solid_mesh.h"
#include "slave/mechanics/deformation_model.h"
#include "slave/mesh/outline.h"
#include "slave/scene/scene.h"

namespace palpate {

// Where a model can be in contact at a single place, at rest. Frame O.
struct TouchablePlace {
  Eigen::Vector3d p_O{0, 0, 0};  // [m]
  int element = -1;              // Contact::element there
};
// The elements of an outline by their midpoints, the nodes of a surface.
std::vector<TouchablePlace> TouchablePlaces(const BoundaryMesh& mesh);
std::vector<TouchablePlace> TouchableNodes(const SurfaceMesh& mesh);
// The middles of the edges of a surface, where the nodes of ten-node tetrahedra are that carry its
// load: an even pressure on a quadratic triangle puts a third on each middle and nothing on the
// corners.
std::vector<TouchablePlace> TouchableMiddles(const SurfaceMesh& mesh);

// Where the tool is. Frame O.
struct ToolIndentation {
  Eigen::Vector3d p_O{0, 0, 0};             // first contact point, at rest [m]
  Eigen::Vector3d normal_O{0, 1, 0};        // outward there, to the tool's centre, unit
  Eigen::Vector3d displacement_O{0, 0, 0};  // since then: u above [m]
  Eigen::Vector3d rolled_O{0, 0, 0};  // way across n of the tool's point from below its centre [m]
};

class RoundIndenter {
 public:
  // With fewer places under the tool its force is kExtrapolated: the mesh is too coarse for it. In
  // the plane a place more or less changes it by a hundredth, in space by a tenth. [measured:
  // round_indenter_test]
  static constexpr int kMinTouched = 3, kMinTouchedInSpace = 8;

  // `radius` of the tool [m], > 0. Throws std::invalid_argument: another radius, or no place.
  RoundIndenter(std::vector<TouchablePlace> places, double radius, ContactLaw law);

  // Force of the tool on the object and its derivative by the displacement at this depth, while the
  // same places are in contact. A tool out of contact has no force; its stiffness is that of the
  // place nearest to the first contact point, which is also the only contact of a tool between
  // places. The moment is about the displaced point, and unknown with fewer than kMinTouched
  // places. `model` is queried several times. `solution`: the places in contact, each with its
  // force.
  [[nodiscard]] ContactResponse Press(const ToolIndentation& press, DeformationModel* model,
                                      Solution* solution) noexcept;

  [[nodiscard]] double radius() const { return radius_; }  // [m]

 private:
  void Gather(const ToolIndentation& press) noexcept;
  void TouchNearest(const ToolIndentation& press, bool presses) noexcept;
  [[nodiscard]] bool LetGo(const Eigen::Vector3d& n, const Solution& solution) noexcept;
  // Puts the places that let go and are inside the tool first. Returns their number.
  [[nodiscard]] std::size_t SortReleased(const ToolIndentation& press,
                                         DeformationModel* model) noexcept;
  static void SetMoment(const ToolIndentation& press, const Solution& solution,
                        ContactResponse* whole);
  [[nodiscard]] Eigen::Matrix3d Stiffness(const ToolIndentation& press,
                                          DeformationModel* model) noexcept;

  std::vector<TouchablePlace> places_;
  double radius_;
  ContactLaw law_;
  bool is_planar_ = false;
  std::vector<Contact> contacts_, released_;
  std::vector<Contact> varied_;  // queries beside that of the contacts, and their responses
  std::vector<ContactResponse> responses_;
};

// Moment of a round tool's force on the object about `p_O`, with the displaced places [N m] (paper
// A's torque).
[[nodiscard]] Eigen::Vector3d MomentAbout(const Solution& solution,
                                          const Eigen::Vector3d& p_O) noexcept;

}  // namespace palpate
