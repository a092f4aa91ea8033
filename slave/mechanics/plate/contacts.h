// Contacts on a clamped circular plate, checked and nondimensional: what both plate models accept;
// and the forces of those whose deflection is prescribed.
#pragma once

#include <span>
#include <string_view>
#include <vector>

#include <Eigen/Core>
#include <Eigen/LU>

#include "slave/mechanics/deformation_model.h"
#include "slave/mechanics/plate/green.h"

namespace palpate::plate {

// Frame O: origin at the plate's centre, z along the outward normal; an indentation is along -z.
struct Geometry {
  double radius = 0;     // a [m]
  double thickness = 0;  // t [m]
};

// One contact; deflections and forces are positive along -z.
struct Touch {
  Contact::Kind kind = Contact::Kind::kDisplacement;
  Disc disc;         // by the radius a
  double value = 0;  // prescribed deflection by a, or load [N]

  [[nodiscard]] bool moved() const { return kind == Contact::Kind::kDisplacement; }
};

// Converts contacts to `touches` (resized; no allocation once it was as large). Empty if all are
// possible, else the reason: a value that is not finite; a component across the normal; a point off
// the disc; a contact over the rim; a displaced point on the rim; overlapping contacts of which one
// is displaced; deflections beyond 1e6 radii.
std::string_view Check(std::span<const Contact> contacts, const Geometry& geometry,
                       std::vector<Touch>* touches);

// Throws std::invalid_argument: radius, thickness or modulus not positive and finite, thickness
// beyond radius / 10, nu outside -1 < nu <= 0.5.
void RequirePlate(const Geometry& geometry, double young_modulus, double poisson_ratio);

// Among contacts with a common compliance matrix, those whose deflection is prescribed: their
// forces, and every contact's stiffness.
class MovedContacts {
 public:
  // Forgets all; then adds the contact with this index.
  void Clear() { contacts_.clear(); }
  void Add(Eigen::Index contact) { contacts_.push_back(contact); }
  [[nodiscard]] const std::vector<Eigen::Index>& contacts() const { return contacts_; }

  // `compliance`: deflection at the row's contact by a unit load at the column's. False: singular
  // to working precision (condition beyond 1e12 after scaling): points too close to be
  // distinguished, or one that cannot move. No allocation for known sizes.
  bool Factorise(const Eigen::MatrixXd& compliance) noexcept;
  // Forces, in the order of contacts(), for deflections; in place.
  void Solve(Eigen::VectorXd& deflections) noexcept;
  // d force / d deflection of one contact with the prescribed values of the others fixed; 0: it
  // cannot move.
  [[nodiscard]] double Stiffness(const Eigen::MatrixXd& compliance,
                                 Eigen::Index contact) const noexcept;

 private:
  std::vector<Eigen::Index> contacts_;
  Eigen::VectorXd scale_;    // 1 / sqrt of a contact's own compliance
  Eigen::MatrixXd scaled_;   // their part of the compliance, with ones on the diagonal
  Eigen::MatrixXd inverse_;  // of scaled_
  Eigen::PartialPivLU<Eigen::MatrixXd> factor_;
  Eigen::VectorXd solution_;
};

}  // namespace palpate::plate
