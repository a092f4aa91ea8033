// A rigid tool that touches nodes of a body: unilateral contact with Coulomb's friction.
//
//   normal:      lambda_n >= 0,  gap >= 0,  lambda_n gap = 0
//   tangential:  |lambda_t| <= mu lambda_n;  a node that sticks stays where it touched the tool,
//                one that slips is dragged against its sliding
//
// In each step of Newton's method every node is free, sticks or slips. A sticking node has the
// displacement of the tool. A slipping node has it along the tool's normal, with a tangential load
// of mu times its normal reaction. The step follows that reaction (AddFrictionOf) and the sliding
// direction (turning). After the step a node with a pulling reaction becomes free, a free node
// inside the tool touches, a node whose reaction leaves Coulomb's cone slips, and a node that slips
// so little that its friction would reverse it sticks (a primal-dual active set;
// Alart and Curnier, Comput. Methods Appl. Mech. Eng. 92, 1991; Hueeber, Stadler and Wohlmuth, SIAM
// J. Sci. Comput. 30, 2008). Sliding is measured per increment of the tool's path.
//
// A node at the rim of a flat face is held by its share of area (rim_share.h): the face pushes it
// through a spring, by the same laws. The share of a node that sticks is that where it touched.
//
// Units of fem_body.h: length the larger side, force E times its square.
#pragma once

#include <algorithm>
#include <cmath>
#include <cstdint>
#include <span>
#include <vector>

#include <Eigen/Core>

#include "slave/mechanics/fem/constraints.h"
#include "slave/mechanics/linear/block_matrix.h"
#include "slave/scene/scene.h"

namespace palpate::fem {

// A node of the surface that supports do not hold completely.
struct TouchableNode {
  int node = -1;                    // of the body
  Eigen::Vector3d rest{0, 0, 0};    // position at rest
  Eigen::Vector3d normal{0, 0, 0};  // outward, unit
  double edge = 0;                  // mean length of the edges around it
  double part = 0;                  // PartRadius (rim_share.h)
  double stiffness = 0;             // stiffness of the node against a force normal to the surface
  double modulus = 1;               // Young's modulus around it, relative to the body's
  Eigen::Vector3d free{1, 1, 1};    // per component: 0 where a support holds it
};

class ToolContact {
 public:
  struct Placement {
    Eigen::Vector3d p{0, 0, 0};       // first contact point of the apex, at rest
    Eigen::Vector3d normal{0, 0, 1};  // outward there, unit: the tool's axis
    double width = 0;                 // of a flat tool
    double radius = 0;                // of a contact that has its own, else 0
  };

  // `friction`: mu; infinite: bonded, a node that touches sticks until it is pulled. `surface` must
  // outlive this.
  ToolContact(const Tool& tool, const Placement& placement, double friction, double poisson_ratio,
              std::span<const TouchableNode> surface);

  void Reset() noexcept;
  // An increment to `displacement` of the apex, from the accepted state, in which nodes have moved
  // by `u`. May be called again for another increment from there.
  void Begin(const Eigen::Vector3d& displacement, const NodeVector& u) noexcept;
  // Owners of nodes of the body: a tool's number, or one of these.
  static constexpr int kNoTool = -1, kTaken = -2;  // kTaken: fixed by another contact
  // Makes nodes that touch this tool its own.
  void Claim(int me, std::vector<int>* owner) const noexcept;
  // What moved the nodes last. After a prediction, shares of area follow them. After a correction,
  // forces are so accurate that a node that is pulled lets go.
  enum class After : std::uint8_t { kPrediction, kStep, kCorrection };
  // Updates which nodes touch and stick, after the displacements `u` and with the nodal forces
  // `reaction`, without the tool's own friction. `slack`: tolerance of forces relative to the
  // largest one, and of gaps relative to the tool's way in this increment [-]. `me`: this tool's
  // number. Returns true if a node changed that the tool holds.
  bool UpdateTouching(const NodeVector& u, const NodeVector& reaction, double slack, After after,
                      int me, std::vector<int>* owner) noexcept;
  // Updates the forces of the springs after the displacements `u`.
  void UpdateSprings(const NodeVector& u) noexcept;
  // Updates the friction of the nodes that slip, after the displacements `u`, with the nodal forces
  // `reaction`.
  void UpdateFriction(const NodeVector& u, const NodeVector& reaction) noexcept;
  // change += the change of friction on nodes that slip, because the normal forces change with the
  // displacements `motion`.
  void AddFrictionOf(const NodeVector& motion, const BlockMatrix& tangent,
                     NodeVector* change) const noexcept;
  [[nodiscard]] bool has_friction() const { return friction_ > 0 && !std::isinf(friction_); }
  // Returns whether a node slips with friction.
  [[nodiscard]] bool slips() const {
    return has_friction() &&
           std::ranges::any_of(points_, [](const Point& p) { return p.state == State::kSlips; });
  }
  // Lets the shares of area follow the nodes that do not stick. Returns the largest change [-].
  double UpdateShares(const NodeVector& u) noexcept;
  // The forces that nodes have at the end of an increment, which is accepted.
  void Accept(const NodeVector& u, const NodeVector& reaction) noexcept;
  // Returns to the state that was accepted last.
  void Retreat() noexcept { points_ = accepted_.points; }
  // Stores the accepted state, and returns to the stored one.
  void Keep() noexcept { kept_ = accepted_; }
  void TakeBack() noexcept;

  void AddTouched(std::vector<TouchedNode>* touched) const noexcept;
  // Displacement of the tool in this increment, which its sticking nodes share.
  [[nodiscard]] Eigen::Vector3d way() const { return displacement_ - accepted_.displacement; }
  void Carry(const Eigen::Vector3d& way, NodeVector* moved) const noexcept;
  // Adds the stiffness of springs and of rotating friction, times `times`, to the tangent.
  void AddStiffness(double times, BlockMatrix* tangent) const noexcept;
  // f_ext = base on all nodes within reach, then f_ext += friction on nodes that slip, and springs.
  void Unload(const NodeVector& base, NodeVector* f_ext) const noexcept;
  void Load(NodeVector* f_ext) const noexcept;

  // The following four are of the accepted state: the tool's force on the body, its moment about
  // the displaced apex, the number of touching nodes, and the distance of the farthest one from the
  // apex.
  [[nodiscard]] const Eigen::Vector3d& force() const { return accepted_.force; }
  [[nodiscard]] const Eigen::Vector3d& moment() const { return accepted_.moment; }
  [[nodiscard]] bool is_disc() const { return tool_.shape == Tool::Shape::kFlat; }
  [[nodiscard]] int touching() const { return accepted_.touching; }
  // Returns whether a node touches in this increment.
  [[nodiscard]] bool touches() const {
    return std::ranges::any_of(points_, [](const Point& p) { return p.state != State::kApart; });
  }
  // Work of the springs at the rim, twice [units].
  [[nodiscard]] double spring_work() const { return accepted_.spring_work; }
  [[nodiscard]] double reach() const { return accepted_.reach; }
  // Returns whether a node was assigned to another tool.
  [[nodiscard]] bool shares() const { return shares_; }
  // Returns whether the set of touching nodes converged within the permitted number of changes per
  // increment.
  [[nodiscard]] bool settles() const;
  // Estimates the error of the force from those of the nodes' reactions and displacements. The
  // error at the time when a node touches stays, since it moves the place where the node sticks.
  void EstimateError(const NodeVector& reaction, const NodeVector& u) noexcept;
  [[nodiscard]] double error() const { return std::max(accepted_.error, accepted_.error_at_touch); }

  [[nodiscard]] const Eigen::Vector3d& displacement() const { return accepted_.displacement; }
  // How far the apex has moved into the body at rest.
  [[nodiscard]] double depth() const { return -placement_.normal.dot(accepted_.displacement); }
  [[nodiscard]] const Placement& placement() const { return placement_; }
  // Length that the path of one increment should not exceed.
  [[nodiscard]] double edge() const { return edge_; }

 private:
  enum class State : std::uint8_t { kApart, kSticks, kSlips };
  struct Point {
    const TouchableNode* at = nullptr;
    Eigen::Vector3d anchor{0, 0, 0};  // displacement relative to the tool, of the accepted state
    Eigen::Vector3d before{0, 0, 0};  // displacement in the accepted state
    double depth_before = 0;          // inside the tool in the accepted state
    // `anchor` if it touches in this increment: the nodes move steadily from the accepted state to
    // the prediction.
    Eigen::Vector3d first_anchor{0, 0, 0};
    Eigen::Vector3d normal{0, 0, 1};  // of the tool's force on it, unit
    double least = 0;                 // displacement along the normal at which it touches
    double share = 1;                 // of its area under the face
    bool reached = false;             // the tool is above it
    bool is_new = false;              // it touched in this increment
    bool was_held = false;            // it touched in the accepted state
    bool has_left = false;            // it touched, and left in this increment
    // Steps of the search move a node off the tool and back, so one that left once returns to its
    // place. One that leaves again, or after a correction, has let go. If it returns to a bonded
    // tool, it sticks from the end of the increment on.
    bool is_let_go = false;
    State state = State::kApart;
    Eigen::Vector3d friction{0, 0, 0};  // of one that slips
    Eigen::Vector3d aside{0, 0, 0};     // unit, across friction and normal
    // Stiffness along `aside`, because friction turns with the sliding direction.
    double turning = 0;
    bool on_spring = false;           // the last update pushed it by a spring
    Eigen::Vector3d spring{0, 0, 0};  // force of one at the rim
    Eigen::Matrix3d spring_stiffness = Eigen::Matrix3d::Zero();  // -d spring / d u, symmetric
  };
  struct Accepted {
    Eigen::Vector3d displacement{0, 0, 0};
    std::vector<Point> points;  // in the surface's order
    Eigen::Vector3d force{0, 0, 0}, moment{0, 0, 0};
    int touching = 0;
    double spring_work = 0;
    double reach = 0;
    bool has_new_touch = false;  // a node has touched since the last estimate
    double error = 0, error_at_touch = 0;
  };

  [[nodiscard]] bool is_face() const {
    return tool_.shape == Tool::Shape::kFlat || tool_.shape == Tool::Shape::kRectangle;
  }
  static bool IsAtRim(const Point& point);
  // A free point touches, or returns.
  static void Touch(Point* point);
  void FindGap(const NodeVector& u, Point* point) const noexcept;
  [[nodiscard]] double DepthOf(const Eigen::Vector3d& x,
                               const Eigen::Vector3d& displacement) const noexcept;
  [[nodiscard]] bool IsNear(const TouchableNode& at, const Eigen::Vector3d& moved) const noexcept;
  [[nodiscard]] double ShareOf(const TouchableNode& at,
                               const Eigen::Vector3d& moved) const noexcept;
  [[nodiscard]] Eigen::Vector3d CentreNear(const Eigen::Vector3d& x,
                                           const Eigen::Vector3d& displacement) const noexcept;
  // The anchor of a free node that touches within this increment, and moves by `moved` to its end.
  [[nodiscard]] Eigen::Vector3d AnchorAt(const Point& point,
                                         const Eigen::Vector3d& moved) const noexcept;
  // The force of the tool on a point.
  [[nodiscard]] Eigen::Vector3d ForceOn(const Point& point,
                                        const NodeVector& reaction) const noexcept;
  State Pulled(const Eigen::Vector3d& force, Point* point) const noexcept;
  State Next(const NodeVector& u, const NodeVector& reaction, double force_slack,
             Point* point) const noexcept;
  [[nodiscard]] Eigen::Vector3d DragAt(double most, const Eigen::Vector3d& slid,
                                       const Point& point) const noexcept;
  static void Turn(const Eigen::Vector3d& trial, double turning, Point* point);
  void Drag(double most, const Eigen::Vector3d& trial, const Eigen::Vector3d& slid,
            Point* point) const noexcept;
  enum class Judged { kNothing, kFriction, kState };
  State PushBySpring(const Eigen::Vector3d& moved, Judged judged, Point* point) const noexcept;

  Tool tool_;
  Placement placement_;
  double friction_, poisson_ratio_;
  std::span<const TouchableNode> surface_;
  double edge_;
  Eigen::Vector3d displacement_{0, 0, 0};
  double way_ = 0;  // length of the last increment
  Accepted accepted_, kept_;
  std::vector<Point> points_;  // in the surface's order
  After after_ = After::kPrediction;
  int judged_ = 0, changed_ = 0;  // in this increment; with changes
  double slack_ = 0;              // accepted gap
  bool shares_ = false;
};

}  // namespace palpate::fem
