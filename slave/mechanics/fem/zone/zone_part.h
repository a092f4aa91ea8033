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
// over, either at all nodes and accelerated (fixed_point_mixer.h), or at the few nodes where it has
// changed most; finds lambda; moves the nodes. What a step still lacks is known from the dual
// solution z = G E (E^T G E)^-1: the force lacks z . (r' - r).
//
// Nondimensional. Sources: initial loads, Zienkiewicz, Valliappan and King, Int. J. Numer. Meth.
// Eng. 1, 1969; global-local split, Gendre, Allix, Gosselet and Comte, Comput. Mech. 44, 2009.
#pragma once

#include <memory>
#include <utility>
#include <vector>

#include <Eigen/Core>

#include "slave/mechanics/fem/zone/field_samples.h"
#include "slave/mechanics/fem/zone/fixed_point_mixer.h"
#include "slave/mechanics/fem/zone/near_green.h"
#include "slave/mechanics/fem/zone/neo_hookean_tets.h"
#include "slave/mechanics/fem/zone/zone.h"
#include "slave/mechanics/fem/zone/zone_contact.h"

namespace palpate {

class ZonePart {
 public:
  // By a unit motion of the contact along each axis, or by a unit load with the other sign: forces
  // on its points, the same on the samples, displacement of the zone's nodes.
  struct Dual {
    Eigen::MatrixXd forces, sampled_load, u;
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
  [[nodiscard]] const Eigen::VectorXd& taken() const { return taken_; }
  // The points on which a force acts; three numbers per point, those of others are anything.
  [[nodiscard]] const std::vector<int>& pressed_points() const { return pressed_points_; }
  [[nodiscard]] const Eigen::VectorXf& pressed_forces() const { return pressed_forces_; }
  [[nodiscard]] FieldSamples& samples() { return samples_; }
  [[nodiscard]] const FieldSamples& samples() const { return samples_; }
  [[nodiscard]] const ContactForces& contact_forces() const { return *forces_; }
  [[nodiscard]] Eigen::Vector3d Force() const { return forces_->Sum(); }
  // Of the contact's points.
  [[nodiscard]] Eigen::Vector3d MeanDisplacement() const;
  // What further steps will change the force by about, or a load's displacement.
  [[nodiscard]] double Remaining() const;
  [[nodiscard]] bool IsFinite() const { return u_.allFinite() && load_.allFinite(); }
  // Smallest det F of the zone.
  [[nodiscard]] double smallest_jacobian() const { return smallest_jacobian_; }

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
  void TakeMostChanged() noexcept;
  void SetPressed() noexcept;

  Zone zone_;
  ZoneContact contact_;
  NeoHookeanTets tets_;
  FieldSamples samples_;
  Eigen::MatrixXf green_, columns_;  // G, G E
  std::unique_ptr<ContactForces> forces_;
  Dual dual_;
  FixedPointMixer mixer_;
  Eigen::VectorXd prescribed_, way_;  // now; since the state before
  Eigen::VectorXd u_, load_;
  Eigen::VectorXd r_, taken_, next_;  // of the present displacement; taken over; to be taken
  Eigen::VectorXf moved_;             // G r as taken
  struct {
    Eigen::VectorXd r, taken;
    Eigen::VectorXf moved;
  } before_;  // at the state before
  std::vector<int> pressed_points_;
  Eigen::VectorXf pressed_forces_;
  struct {
    Eigen::VectorXd gap, at, moved;
    Eigen::VectorXf load, u, points;
    std::vector<std::pair<double, int>> changed;
    std::vector<int> places;
  } room_;
  int steps_ = 0;    // since what is prescribed has changed
  int few_ = 0;      // steps since all of r was taken
  double lack_ = 0;  // of the force
  Eigen::Vector3d last_force_{0, 0, 0};
  double last_ = 0;  // change of the force by the last step
  double smallest_jacobian_ = 1;
};

}  // namespace palpate
