// One nonlinear zone in a linear body, with the contact in it.
//
// What the zone's tetrahedra resist beyond their linearisation acts on the linear body as a load:
//
//   u = G (E lambda - r) + u_others,   r = f_neo-Hooke(u) - f_linear(u),   E^T u = prescribed
//
// G: Green's functions of the whole linear body between the zone's nodes (near_green.h); E: the
// weights of the contact's points; lambda: their forces, prescribed, found from prescribed
// displacements, or those of a rigid tool (tool_contact.h); u_others: what other zones do.
// It is Newton's method with the tangent at rest, condensed exactly onto the zone. A step takes r
// over (zone_loads.h), finds lambda and moves the nodes. What a step still lacks is known from the
// dual solution z = G E (E^T G E)^-1: the force lacks z . (r' - r).
//
// Nondimensional. Sources: initial loads, Zienkiewicz, Valliappan and King, Int. J. Numer. Meth.
// Eng. 1, 1969; global-local split, Gendre, Allix, Gosselet and Comte, Comput. Mech. 44, 2009.
#pragma once

#include <memory>
#include <vector>

#include <Eigen/Core>

#include "slave/mechanics/fem/zone/near/field_samples.h"
#include "slave/mechanics/fem/zone/near/near_green.h"
#include "slave/mechanics/fem/zone/neo_hookean_tets.h"
#include "slave/mechanics/fem/zone/zone.h"
#include "slave/mechanics/fem/zone/zone_contact.h"
#include "slave/mechanics/fem/zone/zone_loads.h"

namespace palpate {

class ZonePart {
 public:
  // By a unit motion of the contact along each axis, or by a unit load with the other sign: forces
  // on its points, the same on the samples, displacement of the zone's nodes.
  struct Dual {
    Eigen::MatrixXd forces, sampled_load, u;
  };
  // The points on which a force acts; three numbers per point, those of others are anything.
  struct Pressed {
    std::vector<int> points;
    Eigen::VectorXf forces;
  };
  // The columns of the zone's nodes are ready. Throws std::runtime_error: they do not reach.
  ZonePart(NearGreen& green, Zone zone, double nu, ZoneContact contact);

  void Reset();
  // Something else is prescribed from now on, three numbers per point, or the displacement of the
  // tool. What r will be is extrapolated from the last two states. Does not allocate.
  void Begin(const Eigen::VectorXd& prescribed) noexcept;
  // A step: the zone takes its loads, then the contact is pressed, then the zone is moved. `all`:
  // at all nodes. `at_others`, `others`: displacement by other zones, of the points and of the
  // zone's nodes. None allocates.
  void TakeLoads(bool all) noexcept;
  void Press(const Eigen::VectorXd& at_others) noexcept;
  void Move(const Eigen::VectorXd& others) noexcept;

  [[nodiscard]] const Zone& zone() const { return zone_; }
  [[nodiscard]] const ZoneContact& contact() const { return contact_; }
  [[nodiscard]] const Eigen::VectorXd& u() const { return u_; }
  // E lambda - r: the load on the linear body; r as it was taken.
  [[nodiscard]] const Eigen::VectorXd& load() const { return load_; }
  [[nodiscard]] const Eigen::VectorXd& taken() const { return loads_->taken(); }
  [[nodiscard]] const Pressed& pressed() const { return pressed_; }
  [[nodiscard]] FieldSamples& samples() { return samples_; }
  [[nodiscard]] const FieldSamples& samples() const { return samples_; }
  [[nodiscard]] const ContactForces& contact_forces() const { return *forces_; }
  [[nodiscard]] Eigen::Vector3d Force() const { return forces_->Sum(); }
  // For the contact's points.
  [[nodiscard]] Eigen::Vector3d MeanDisplacement() const;
  // What further steps will change the force by about, or a load's displacement.
  [[nodiscard]] double Remaining() const;
  [[nodiscard]] bool IsFinite() const { return u_.allFinite() && load_.allFinite(); }
  // Smallest det F of the zone.
  [[nodiscard]] double smallest_jacobian() const { return step_.smallest_jacobian; }

  // Finds the dual problem of the present state of a tool's points.
  void RefreshDual() noexcept;
  [[nodiscard]] const Dual& dual() const { return dual_; }
  // The load on the samples by displacements of the samples by something else, the contact held.
  void HeldLoad(const Eigen::VectorXd& moved, Eigen::VectorXd* load) noexcept;
  // The state is accepted: see ToolContact::Accept.
  void Accept() noexcept;
  // From a zone at another place, whose node `number[n]` is this one's n, -1: none. `others` as in
  // Move.
  void TakeState(const ZonePart& other, const std::vector<int>& number,
                 const Eigen::VectorXd& others);

 private:
  void SampleZone(const NearGreen& green);
  void Condense(NearGreen& green);
  void SetPressed() noexcept;

  Zone zone_;
  ZoneContact contact_;
  NeoHookeanTets tets_;
  FieldSamples samples_;
  std::unique_ptr<ZoneLoads> loads_;
  Eigen::MatrixXf columns_;  // G E
  std::unique_ptr<ContactForces> forces_;
  Pressed pressed_;
  Dual dual_;
  Eigen::VectorXd prescribed_, way_;  // now; since the state before
  Eigen::VectorXd u_, load_;
  struct {
    Eigen::VectorXd gap, at, moved;
    Eigen::VectorXf u, points;
  } room_;
  struct LastStep {
    int count = 0;    // since what is prescribed has changed
    double lack = 0;  // of the force
    double change = 0;
    Eigen::Vector3d force{0, 0, 0};
    double smallest_jacobian = 1;
  } step_;
};

}  // namespace palpate
