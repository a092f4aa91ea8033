// All rigid tools that touch a body. Assigns each node to one tool, support or contact.
#pragma once

#include <span>
#include <vector>

#include <Eigen/Core>

#include "shared/mesh/solid_mesh.h"
#include "slave/mechanics/fem/constraints.h"
#include "slave/mechanics/fem/fem_body.h"
#include "slave/mechanics/fem/tool_contact.h"

namespace palpate::fem {

class ToolContacts {
 public:
  // Stores references to its arguments. Nodes that supports hold in some direction are not touched.
  ToolContacts(const SolidMesh& mesh, double poisson_ratio, const FemBody& body,
               Constraints& constraints);

  // Sets the tools. Call it after the other contacts are in the constraints. A tool at the same
  // place as before keeps its state. Lengths in metres. False: there is no surface at a place.
  struct Touch {
    Tool tool;
    Eigen::Vector3d p_O{0, 0, 0};
    double width = 0, radius = 0, friction = 0;  // see ToolContact
  };
  [[nodiscard]] bool Set(std::span<const Touch> touches);
  void Reset() noexcept;
  [[nodiscard]] bool empty() const { return tools_.empty(); }
  [[nodiscard]] int size() const { return static_cast<int>(tools_.size()); }
  // Returns whether a tool touches a node in this increment.
  [[nodiscard]] bool touches() const { return std::ranges::any_of(tools_, &ToolContact::touches); }
  [[nodiscard]] const ToolContact& at(int tool) const {
    return tools_[static_cast<std::size_t>(tool)];
  }

  // Begins an increment of one tool to a displacement of its apex [units], see ToolContact::Begin.
  void Begin(int tool, const Eigen::Vector3d& displacement, const NodeVector& u) noexcept {
    tools_[static_cast<std::size_t>(tool)].Begin(displacement, u);
  }
  // Updates which nodes touch, see ToolContact::UpdateTouching. Returns whether they have changed.
  bool UpdateTouching(const NodeVector& u, const NodeVector& reaction, double slack,
                      ToolContact::After after) noexcept;
  // Returns the displacement of a tool in the present increment.
  [[nodiscard]] Eigen::Vector3d Way(int tool) const { return at(tool).way(); }
  void Carry(std::span<const Eigen::Vector3d> ways, NodeVector* moved) const noexcept;
  void AddStiffness(double times, BlockMatrix* tangent) const noexcept;
  void Load(const NodeVector& base, NodeVector* f_ext) const noexcept;
  void UpdateSprings(const NodeVector& u) noexcept;
  // Of nodes that slip with friction, see ToolContact.
  void UpdateFriction(const NodeVector& u, const NodeVector& reaction) noexcept;
  void AddFrictionOf(const NodeVector& motion, const BlockMatrix& tangent,
                     NodeVector* change) const noexcept;
  [[nodiscard]] bool have_friction() const {
    return std::ranges::any_of(tools_, &ToolContact::has_friction);
  }
  [[nodiscard]] bool slips() const { return std::ranges::any_of(tools_, &ToolContact::slips); }
  // Returns the largest change of a share of area, see ToolContact::UpdateShares.
  double UpdateShares(const NodeVector& u) noexcept;
  void Accept(const NodeVector& u, const NodeVector& reaction) noexcept;
  void EstimateErrors(const NodeVector& reaction, const NodeVector& u) noexcept;
  // Holds the nodes that touch, after the other contacts have changed.
  void HoldTouched() noexcept;
  // Return to the state that was accepted last; store it, and return to the stored one.
  void Retreat() noexcept;
  void Keep() noexcept;
  void TakeBack() noexcept;

 private:
  const FemBody& body_;
  double poisson_ratio_;
  Constraints& constraints_;
  SurfaceMesh skin_;
  std::vector<Eigen::Vector3d> normals_;  // per node of the mesh
  std::vector<TouchableNode> surface_;
  std::vector<ToolContact> tools_;
  std::vector<int> owner_;  // per node of the body, see ToolContact
  std::vector<TouchedNode> touched_;
};

}  // namespace palpate::fem
