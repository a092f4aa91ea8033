// A rigid tool that touches nodes of a body: unilateral contact with Coulomb's friction.
//
//   normal:      lambda_n >= 0,  gap >= 0,  lambda_n gap = 0
//   tangential:  |lambda_t| <= mu lambda_n;  a node that sticks stays where it touched the tool,
//                one that slips is dragged against its sliding
//
// In each step of Newton's method every node is free, sticks or slips. A sticking node has the
// displacement of the tool. A slipping node has it along the tool's normal, with a tangential load
// of mu times its last normal reaction. After the step a node with a pulling reaction becomes free,
// a free node inside the tool touches, a node whose reaction leaves Coulomb's cone slips, and a
// node that slips so little that its friction would reverse it sticks (a primal-dual active set;
// Alart and Curnier, Comput. Methods Appl. Mech. Eng. 92, 1991; Hueeber, Stadler and Wohlmuth, SIAM
// J. Sci. Comput. 30, 2008). Sliding is measured per increment of the tool's path.
//
// Units of fem_body.h: length the larger side, force E times its square.
#pragma once

#include <cmath>
#include <cstdint>
#include <span>
#include <vector>

#include <Eigen/Core>

#include "slave/mechanics/fem/constraints.h"
#include "slave/mechanics/linear/block_matrix.h"
#include "slave/scene/scene.h"

namespace palpate::fem {

// A node of the surface without fixed components.
struct TouchableNode {
  int node = -1;                    // of the body
  Eigen::Vector3d rest{0, 0, 0};    // position at rest
  Eigen::Vector3d normal{0, 0, 0};  // outward, unit
  double edge = 0;                  // mean length of the edges around it
  double stiffness = 0;             // stiffness of the node against a force normal to the surface
};

class ToolContact {
 public:
  struct Placement {
    Eigen::Vector3d p{0, 0, 0};       // first contact point of the apex, at rest
    Eigen::Vector3d normal{0, 0, 1};  // outward there, unit: the tool's axis
    double width = 0;                 // of a flat tool
  };

  // `friction`: mu; infinite: bonded, a node that touches sticks until it is pulled. `surface` must
  // outlive this.
  ToolContact(const Tool& tool, const Placement& placement, double friction,
              std::span<const TouchableNode> surface);

  void Reset() noexcept;
  // An increment to `displacement` of the apex, from the accepted state, in which nodes have moved
  // by `u`. May be called again for another increment from there.
  void Begin(const Eigen::Vector3d& displacement, const NodeVector& u) noexcept;
  // Owners of nodes of the body: a tool's number, or one of these.
  static constexpr int kNoTool = -1, kTaken = -2;  // kTaken: fixed by another contact
  // Makes nodes that touch this tool its own.
  void Claim(int me, std::vector<int>* owner) const noexcept;
  // Updates which nodes touch and stick, after the displacements `u` and with the nodal forces
  // `reaction`, without the tool's own friction. `slack`: tolerance of forces relative to the
  // largest one, and of gaps relative to the depth [-]. `me`: this tool's number. Returns true if a
  // node changed.
  bool UpdateTouching(const NodeVector& u, const NodeVector& reaction, double slack, bool steps,
                      int me, std::vector<int>* owner) noexcept;
  // The forces that nodes have at the end of an increment, which is accepted.
  void Accept(const NodeVector& u, const NodeVector& reaction) noexcept;

  void AddTouched(std::vector<TouchedNode>* touched) const noexcept;
  // Displacement of the tool in this increment, which its sticking nodes share.
  [[nodiscard]] Eigen::Vector3d way() const { return displacement_ - accepted_displacement_; }
  void Carry(const Eigen::Vector3d& way, NodeVector* moved) const noexcept;
  // Adds the stiffness due to rotating friction, times `times`, to the tangent.
  void AddStiffness(double times, BlockMatrix* tangent) const noexcept;
  // Friction on nodes that slip: f_ext = base + friction on all nodes within reach.
  void Load(const NodeVector& base, NodeVector* f_ext) const noexcept;

  // The following four are of the accepted state: the tool's force on the body, its moment about
  // the displaced apex, the number of touching nodes, and the distance of the farthest one from the
  // apex.
  [[nodiscard]] const Eigen::Vector3d& force() const { return force_; }
  [[nodiscard]] const Eigen::Vector3d& moment() const { return moment_; }
  [[nodiscard]] bool is_disc() const { return tool_.shape == Tool::Shape::kFlat; }
  [[nodiscard]] int touching() const { return touching_; }
  [[nodiscard]] double reach() const { return reach_; }
  // Returns whether a node was assigned to another tool.
  [[nodiscard]] bool shares() const { return shares_; }
  // Returns whether the set of touching nodes converged within the permitted number of changes per
  // increment.
  [[nodiscard]] bool settles() const;
  // Returns the error of the force that results from an error of the reactions of the same nodes.
  [[nodiscard]] Eigen::Vector3d ForceOf(const NodeVector& reaction) const noexcept;

  [[nodiscard]] const Eigen::Vector3d& displacement() const { return accepted_displacement_; }
  [[nodiscard]] double depth() const { return std::abs(placement_.normal.dot(displacement_)); }
  [[nodiscard]] const Placement& placement() const { return placement_; }
  // Length that the path of one increment should not exceed.
  [[nodiscard]] double edge() const { return edge_; }

 private:
  enum class State : std::uint8_t { kApart, kSticks, kSlips };
  struct Point {
    const TouchableNode* at = nullptr;
    Eigen::Vector3d anchor{0, 0, 0};  // displacement relative to the tool, of the accepted state
    Eigen::Vector3d normal{0, 0, 1};  // of the tool's force on it, unit
    double least = 0;                 // displacement along the normal at which it touches
    bool reached = false;             // the tool is above it
    State state = State::kApart;
    Eigen::Vector3d friction{0, 0, 0};  // of one that slips, where it had moved by `judged`
    Eigen::Vector3d judged{0, 0, 0};
    Eigen::Vector3d aside{0, 0, 0};  // unit, across friction and normal
    // Stiffness along `aside`, because friction rotates with the sliding direction.
    double turning = 0;
  };

  void FindGap(const NodeVector& u, Point* point) const noexcept;
  [[nodiscard]] bool IsNear(const TouchableNode& at, const Eigen::Vector3d& moved) const noexcept;
  [[nodiscard]] bool IsUnderFace(const Eigen::Vector3d& from_apex) const noexcept;
  [[nodiscard]] Eigen::Vector3d CentreNear(const Eigen::Vector3d& x) const noexcept;
  // The force of the tool on a point.
  [[nodiscard]] Eigen::Vector3d ForceOn(const Point& point, const NodeVector& reaction,
                                        const Eigen::Vector3d& unit_friction) const noexcept;
  State Next(const NodeVector& u, const NodeVector& reaction, double force_slack,
             Point* point) const noexcept;

  Tool tool_;
  Placement placement_;
  double friction_;
  std::span<const TouchableNode> surface_;
  double edge_;
  Eigen::Vector3d accepted_displacement_{0, 0, 0}, displacement_{0, 0, 0};
  std::vector<Point> accepted_, points_;  // in the surface's order
  bool is_first_ = true;                  // no step was made in this increment
  int judged_ = 0, changed_ = 0;          // in this increment; with changes
  Eigen::Vector3d force_{0, 0, 0}, moment_{0, 0, 0};
  int touching_ = 0;
  double reach_ = 0;
  bool shares_ = false;
};

}  // namespace palpate::fem
