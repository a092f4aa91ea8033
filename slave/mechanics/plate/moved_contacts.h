// Among contacts with a common compliance matrix, those whose deflection is prescribed: their
// forces, and every contact's stiffness.
#pragma once

#include <span>
#include <vector>

#include <Eigen/Core>
#include <Eigen/LU>

namespace palpate::plate {

class MovedContacts {
 public:
  // Forgets all; then adds the contact with this index.
  void Clear() { contacts_.clear(); }
  void Add(Eigen::Index contact) { contacts_.push_back(contact); }
  [[nodiscard]] const std::vector<Eigen::Index>& contacts() const { return contacts_; }

  // `compliance`: of all contacts, deflection at the row's by a load of one at the column's. False:
  // singular to working precision (condition beyond 1e12 after scaling): places too close to be
  // told apart, or one that cannot move. No allocation for known sizes.
  bool Factorise(const Eigen::MatrixXd& compliance) noexcept;
  // Forces, in the order of contacts(), for deflections: in place.
  void Solve(Eigen::VectorXd& deflections) noexcept;
  // d force / d deflection of one contact while the others keep what is prescribed for them; 0: it
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
