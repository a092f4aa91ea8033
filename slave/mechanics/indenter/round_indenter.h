// A rigid round tool pressed into a body: its contact grows with the depth, as in Hertz's theory
// for bodies much larger than the contact.
//
// The tool is a cylinder across the plane in 2D and a sphere in 3D. Its axis is along the outward
// normal n. Each place x of the boundary at rest has the distance rho from the axis. The overlap of
// the tool with the undeformed body is there
//
//   delta = n . (x - p) - n . u - (R - sqrt(R^2 - rho^2))
//
// with the first contact point p and the displacement u since: along n that of the centre, across n
// that of the tool's point which touched first, because a rotating tool rolls. Places with delta >
// 0 may touch: they are moved by u_t - delta n (u_t: u across n), the others are free. Places with
// pulling forces are released until all touching places are pushed: a linear complementarity
// problem. If the stiffness has no positive off-diagonal entry, a released place never touches
// again (Chandrasekaran, Opsearch 7, 1970); a bending body may press places against the tool again,
// so released places are checked once more. Works with any DeformationModel that can move single
// places.
#pragma once

#include <span>
#include <vector>

#include <Eigen/Core>

#include "shared/mesh/solid_mesh.h"
#include "slave/mechanics/deformation_model.h"
#include "slave/mesh/outline.h"
#include "slave/scene/scene.h"

namespace palpate {

// A place at which a model can have a contact, at rest. Frame O.
struct TouchablePlace {
  Eigen::Vector3d p_O{0, 0, 0};  // [m]
  int element = -1;              // Contact::element there
};
// The elements of an outline by their midpoints, the nodes of a surface.
std::vector<TouchablePlace> TouchablePlaces(const BoundaryMesh& mesh);
std::vector<TouchablePlace> TouchableNodes(const SurfaceMesh& mesh);
// Returns the mid-edge nodes of a surface of ten-node tetrahedra, which carry its load: a uniform
// pressure on a quadratic triangle acts with a third on each mid-edge node and not on the corners.
std::vector<TouchablePlace> TouchableMiddles(const SurfaceMesh& mesh);

// Position of the tool. Frame O.
struct ToolIndentation {
  Eigen::Vector3d p_O{0, 0, 0};             // first contact point, at rest [m]
  Eigen::Vector3d normal_O{0, 1, 0};        // outward there, to the tool's centre, unit
  Eigen::Vector3d displacement_O{0, 0, 0};  // since then: u above [m]
  // Distance across n from the centre to the tool's point that touched first [m].
  Eigen::Vector3d rolled_O{0, 0, 0};
};

class RoundIndenter {
 public:
  // With fewer touching places the force is kExtrapolated, because the mesh is too coarse. One
  // place more or less changes the force by a hundredth in 2D and by a tenth in 3D. [measured:
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
  // Moves released places that are inside the tool to the front. Returns their number.
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
  std::vector<Contact> varied_;  // additional queries and their responses
  std::vector<ContactResponse> responses_;
};

// Moment of a round tool's force on the object about `p_O`, with the displaced places [N m] (paper
// A's torque).
[[nodiscard]] Eigen::Vector3d MomentAbout(const Solution& solution,
                                          const Eigen::Vector3d& p_O) noexcept;

}  // namespace palpate
