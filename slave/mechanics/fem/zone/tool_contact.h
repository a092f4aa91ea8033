// A rigid tool on points of an elastic surface: unilateral contact with Coulomb's friction.
//
//   normal:      0 <= lambda_n,  gap >= 0,  lambda_n gap = 0
//   tangential:  |lambda_t| <= mu lambda_n;  a point that sticks stays where it touched the tool,
//   one
//                that slips is dragged against its sliding
//
// The displacement of the points by their forces is free + W lambda. The forces are found by
// projected Gauss-Seidel steps from the last ones (Jourdan, Alart and Jean, Comput. Methods Appl.
// Mech. Eng. 155, 1998). Bonded: a point that touches sticks, and lets go where it would be pulled.
// Sliding is counted per update; the friction of one update never gives energy.
//
// Lengths and forces in any consistent units; three numbers per point.
#pragma once

#include <cstdint>
#include <vector>

#include <Eigen/Core>
#include <Eigen/LU>

#include "slave/scene/scene.h"

namespace palpate {

class ToolContact {
 public:
  struct Placement {
    Eigen::Vector3d p{0, 0, 0};       // first contact point of the apex, at rest
    Eigen::Vector3d normal{0, 0, 1};  // outward there, unit
    double width = 0;                 // of a flat tool
  };
  // `friction`: mu; infinite: bonded. `rest`: the points. `compliance`: W, symmetric.
  ToolContact(const Tool& tool, const Placement& placement, double friction,
              std::vector<Eigen::Vector3d> rest, const Eigen::MatrixXd& compliance);

  void Reset();
  // The tool has moved so far from the first contact.
  void Move(const Eigen::Vector3d& displacement) { displacement_ = displacement; }
  // Where the points meet the tool, from their present displacements.
  void FindGaps(const Eigen::VectorXd& u) noexcept;
  // Forces of the tool on the points, from the present ones. Does not allocate.
  void Solve(const Eigen::VectorXd& free, Eigen::VectorXd* forces) noexcept;
  // The state is accepted: what slid has its new place on the tool.
  void Accept(const Eigen::VectorXd& u) noexcept;

  // Factorises what the touching points are to each other while the same stick and slip. False:
  // nothing touches.
  bool Factorise() noexcept;
  // Then: loads on the points whose work on any small displacement of them is what that
  // displacement takes from the force along each axis (the dual problem); forces by a displacement
  // of the points that the tool does not take part in.
  void DualForces(Eigen::MatrixXd* forces) noexcept;
  void HeldForces(const Eigen::VectorXd& moved, Eigen::VectorXd* forces) noexcept;
  // Mean displacement of the touching points across a direction.
  [[nodiscard]] Eigen::Vector3d Dragged(const Eigen::Vector3d& normal) const;
  [[nodiscard]] int touching() const;
  // From another set of points to this one, at which the same material points have these numbers;
  // -1: none.
  void TakeState(const ToolContact& other, const std::vector<int>& number);
  [[nodiscard]] Eigen::Vector3d apex() const { return placement_.p + displacement_; }

 private:
  enum class State : std::uint8_t { kApart, kSticks, kSlips };
  struct Point {
    Eigen::Vector3d rest{0, 0, 0};
    Eigen::Vector3d anchor{0, 0, 0};  // displacement relative to the tool, of the accepted state
    Eigen::Vector3d normal{0, 0, 1};  // of the force of the tool on it, unit
    double least = 0;                 // displacement along the normal at which it touches
    bool reached = false;             // the tool is above it
    double along = 0, across = 0;     // its own compliance along the normal and across it
    State state = State::kApart;
    Eigen::Vector3d drag{0, 0, 0};  // of one that slips, by its normal force
  };
  struct Direction {
    int row = 0;
    Eigen::Vector3d test, drive;  // what must not move; the force that sees to it
  };
  [[nodiscard]] Eigen::Vector3d NextForce(const Point& point, const Eigen::Vector3d& moved,
                                          const Eigen::Vector3d& force, State* state,
                                          Eigen::Vector3d* drag) const noexcept;

  Tool tool_;
  Placement placement_;
  double friction_;
  std::vector<Point> points_;
  const Eigen::MatrixXd& compliance_;
  Eigen::Vector3d displacement_{0, 0, 0};
  Eigen::VectorXd moved_;
  std::vector<Direction> directions_;
  Eigen::MatrixXd among_;
  Eigen::PartialPivLU<Eigen::MatrixXd> inverse_;
};

}  // namespace palpate
