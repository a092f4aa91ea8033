// One nonlinear zone in a linear body, with the contact in it.
//
// What the zone's tetrahedra resist beyond their linearisation acts on the linear body as a load:
//
//   u = G (E lambda - r) + u_others,   r = f_neo-Hooke(u) - f_linear(u),   E^T u = prescribed
//
// G: Green's functions of the whole linear body between the zone's nodes (near_green.h); E: the
// weights of the contact's points; lambda: their forces, prescribed, found from prescribed
// displacements, or those of a rigid tool (tool_contact.h); u_others: what other zones do.
// It is Newton's method with the tangent at rest, condensed exactly onto the zone; the iteration in
// r is accelerated (fixed_point_mixer.h), so that no tangent is ever factorised. What an iteration
// still lacks is known from the dual solution z = G E (E^T G E)^-1: the force lacks z . (r' - r).
//
// Nondimensional. Sources: initial loads, Zienkiewicz, Valliappan and King, Int. J. Numer. Meth.
// Eng. 1, 1969; global-local split, Gendre, Allix, Gosselet and Comte, Comput. Mech. 44, 2009.
#pragma once

#include <memory>
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
  // By a unit motion of the contact along each axis, or by a unit load with the other sign:
  // displacement of the zone's nodes, loads on them, loads on the samples.
  struct Dual {
    Eigen::MatrixXd u, load, sampled_load;
  };
  // The columns of the zone's nodes are ready. Throws std::runtime_error: they do not reach.
  ZonePart(NearGreen& green, Zone zone, double nu, ZoneContact contact);

  void Reset();
  // One step of the iteration towards the prescribed displacements or under the prescribed forces,
  // three numbers per point, or with the tool moved by the first three. `others`: displacement of
  // the zone's nodes by other zones. Does not allocate.
  void Step(const Eigen::VectorXd& prescribed, const Eigen::VectorXd& others) noexcept;
  // What is prescribed has changed: earlier steps do not tell how to go on.
  void Restart() {
    mixer_.Reset();
    mixed_ = r_;
    restarted_ = true;
  }

  [[nodiscard]] const Zone& zone() const { return zone_; }
  [[nodiscard]] const ZoneContact& contact() const { return contact_; }
  [[nodiscard]] const Eigen::VectorXd& u() const { return u_; }
  // E lambda - r: the load on the linear body.
  [[nodiscard]] const Eigen::VectorXd& load() const { return load_; }
  // The same, as forces on the samples of the zone.
  [[nodiscard]] const Eigen::VectorXd& sampled_load() const { return sampled_load_; }
  [[nodiscard]] FieldSamples& samples() { return samples_; }
  [[nodiscard]] const FieldSamples& samples() const { return samples_; }
  [[nodiscard]] const ContactForces& contact_forces() const { return *forces_; }
  [[nodiscard]] Eigen::Vector3d Force() const { return forces_->Sum(); }
  // Of the contact's points.
  [[nodiscard]] Eigen::Vector3d MeanDisplacement() const;
  // What further steps will change the force by about, or a load's displacement.
  [[nodiscard]] double Remaining() const;
  [[nodiscard]] bool IsFinite() const { return u_.allFinite() && load_.allFinite(); }
  [[nodiscard]] double SmallestJacobian() const noexcept {
    return tets_.SmallestJacobian(u_.data());
  }

  // Finds the dual problem of the present state of a tool's points.
  void RefreshDual() noexcept;
  [[nodiscard]] const Dual& dual() const { return dual_; }
  // The load on the samples by displacements of the samples by something else, the contact held.
  void HeldLoad(const Eigen::VectorXd& moved, Eigen::VectorXd* load) noexcept;
  // The state is accepted: see ToolContact::Accept.
  void Accept() noexcept;
  // From a zone at another place, whose node `number[n]` is this one's n, -1: none; `u` has the
  // displacement of all nodes.
  void TakeState(const ZonePart& other, const std::vector<int>& number, Eigen::VectorXd u);

 private:
  void SampleZone(const NearGreen& green);
  void Condense(NearGreen& green);
  void SetLoad() noexcept;

  Zone zone_;
  ZoneContact contact_;
  NeoHookeanTets tets_;
  FieldSamples samples_;
  Eigen::MatrixXf green_, columns_;  // G, G E
  std::unique_ptr<ContactForces> forces_;
  Dual dual_;
  FixedPointMixer mixer_;
  Eigen::VectorXd u_, load_, sampled_load_;
  Eigen::VectorXd r_, mixed_;  // of the present displacement; what it was found with
  struct {
    Eigen::VectorXd gap, at, moved;
    Eigen::VectorXf load, u, points;
  } room_;
  bool restarted_ = true, is_alone_ = true;
  double lack_ = 0;    // of the force
  double change_ = 0;  // of the force, by the last step
};

}  // namespace palpate
