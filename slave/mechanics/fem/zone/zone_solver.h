// Equilibrium of one nonlinear zone in a linear body under prescribed displacements of a contact's
// points, or under forces on them.
//
//   f_int(u) + S_rest u_b = E lambda + h,   E^T u = prescribed (or lambda is)
//
// f_int: internal force of the zone's neo-Hookean tetrahedra; S_rest: the rest of the body on the
// zone's border b (linear_rest.h); E: the weights of the contact's points; lambda: their forces; h:
// what everything outside the zone does to it beyond S_rest, namely other contacts and the rest's
// nonlinearity (zone_set.h). One step with an old tangent A, refreshed beside the loop:
//
//   d = A^-1 (E lambda + h - f_int - S_rest u),   (E^T A^-1 E) dlambda = prescribed - E^T (u + d)
//   u += d + A^-1 E dlambda
//
// Nondimensional. Source of the split: global-local coupling (Gendre, Allix, Gosselet and Comte,
// Comput. Mech. 44, 2009); here the linear part is condensed beforehand.
#pragma once

#include <array>
#include <utility>
#include <vector>

#include <Eigen/Cholesky>
#include <Eigen/Core>

#include "slave/mechanics/fem/zone/neo_hookean_tets.h"
#include "slave/mechanics/fem/zone/zone.h"
#include "slave/mechanics/linear/sparse_ldlt.h"

namespace palpate {

// A zone with what surrounds it: immutable, made once per place.
struct ZoneBody {
  Zone zone;
  NeoHookeanTets tets;
  Eigen::MatrixXd rest;        // S_rest
  std::vector<char> held;      // per unknown
  SparseLdlt::Matrix pattern;  // upper triangle, order of elimination
  std::vector<int> unknown;    // per 3 node + component: its row in the pattern
};

// `nodes`: positions of the mesh in units of length. `held` per unknown of the zone.
ZoneBody MakeZoneBody(Zone zone, const std::vector<Eigen::Vector3d>& nodes, std::vector<char> held,
                      Eigen::MatrixXd rest, double nu);

// Where a contact acts: points that are each a weighted mean of nodes, numbered as in the zone. The
// displacement or force of every point is prescribed.
struct ZoneContact {
  using Point = std::vector<std::pair<int, double>>;
  std::vector<Point> points;
  bool loaded = false;  // the force on its only point is prescribed

  [[nodiscard]] int unknowns() const { return 3 * static_cast<int>(points.size()); }
};

// Of displacements of the zone.
Eigen::Vector3d MeanOf(const Eigen::VectorXd& u, const ZoneContact::Point& point);

// A factorised tangent and what forces on the contact's points do to it.
class ZoneTangent {
 public:
  // Keeps a reference. Takes memory for as many points.
  ZoneTangent(const ZoneBody& body, ZoneContact contact);

  // At `u`. False: it cannot be factored. Allocates only inside BLAS.
  bool Compute(const Eigen::VectorXd& u);
  // x becomes A^-1 x, in the zone's order.
  void Solve(Eigen::VectorXd* x);
  // A^-1 E, and E^T A^-1 E factorised.
  [[nodiscard]] const Eigen::MatrixXd& columns() const { return columns_; }
  [[nodiscard]] const Eigen::LDLT<Eigen::MatrixXd>& compliance() const { return compliance_; }

 private:
  void Assemble(const Eigen::VectorXd& u);

  const ZoneBody& body_;
  ZoneContact contact_;
  SparseLdlt::Matrix matrix_;
  SparseLdlt factor_;
  std::vector<std::array<int, 144>> entry_;   // per tetrahedron: where its block goes; -1: nowhere
  std::vector<std::pair<int, double>> rest_;  // entries of S_rest
  Eigen::VectorXd permuted_;
  Eigen::MatrixXd columns_, compliance_matrix_;
  Eigen::LDLT<Eigen::MatrixXd> compliance_;
};

class ZoneSolver {
 public:
  // Keeps a reference.
  ZoneSolver(const ZoneBody& body, ZoneContact contact);

  // The body is at rest again.
  void Reset();
  // One step towards the prescribed displacements or under the prescribed forces (three per point)
  // with `tangent`. Does not allocate.
  void Step(ZoneTangent& tangent, const Eigen::VectorXd& prescribed) noexcept;
  void SetLoad(const Eigen::VectorXd& h) { load_ = h; }
  [[nodiscard]] const Eigen::VectorXd& u() const { return u_; }
  void SetDisplacement(const Eigen::VectorXd& u) { u_ = u; }
  // On every point.
  [[nodiscard]] const Eigen::VectorXd& forces() const { return lambda_; }
  [[nodiscard]] Eigen::Vector3d Force() const;
  // What the last step added: to the force; of a load, to the mean displacement by its forces.
  [[nodiscard]] const Eigen::Vector3d& last_change() const { return change_; }
  // What further steps will change by about, if each changes by the same part of the last one.
  [[nodiscard]] double Remaining() const;
  [[nodiscard]] const ZoneContact& contact() const { return contact_; }
  [[nodiscard]] const ZoneBody& body() const { return body_; }
  // f_int(u) + S_rest u, and the same of the linear zone.
  void InternalForce(const Eigen::VectorXd& u, Eigen::VectorXd* f) const noexcept;
  void LinearForce(const Eigen::VectorXd& u, Eigen::VectorXd* f) const noexcept;

 private:
  void AddRest(const Eigen::VectorXd& u, Eigen::VectorXd* f) const noexcept;

  const ZoneBody& body_;
  ZoneContact contact_;
  Eigen::VectorXd u_, load_, lambda_, residual_, gap_;
  Eigen::Vector3d change_ = Eigen::Vector3d::Zero();
  double change_before_ = 0;
};

}  // namespace palpate
