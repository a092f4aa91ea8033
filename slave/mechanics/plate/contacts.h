// Contacts on a clamped circular plate, checked and nondimensional: what both plate models accept;
// and the forces of those whose deflection is prescribed.
#pragma once

#include <array>
#include <cstddef>
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
  // A disc that is moved is a rigid flat tool: all of the plate below it moves alike. A load, and a
  // disc narrower than a fifth of the thickness, is even, and its deflection is the mean over it.
  bool rigid = false;

  [[nodiscard]] bool moved() const { return kind == Contact::Kind::kDisplacement; }
};
// Whether a tool of this radius [radii] is rigid.
bool IsRigidTool(double tool_radius, double slenderness) noexcept;

// A rigid flat tool as a thin plate meets it [radii].
//
// The plate is held to the tool as if it were clamped 0.64 t inside the tool's edge: over that
// length its outer face shears and turns below the edge. The face itself yields as a half-space
// does to a flat punch (Sneddon 1965). Both are for small deflections, from t / 80 to a / 10 and
// tools of 0.02 a to 0.4 a within 4 % of axisymmetric solids (rigid_tool_test.cpp).
struct RigidTool {
  double radius = 0;      // of the clamped part
  double compliance = 0;  // of the face: deflection by F a^2 / D
};
RigidTool RigidToolOf(double tool_radius, double slenderness) noexcept;
// Points that hold the plate as the clamped disc does: on two circles, as stiff at the plate's
// centre within 0.2 % for discs up to 0.4 a.
constexpr std::size_t kToolPoints = 16;
std::array<Eigen::Vector2d, kToolPoints> ToolPoints(const Disc& clamped) noexcept;

// What a set of contacts consists of: a load as a whole, a rigid tool at its points, which come
// one after another.
struct ContactPart {
  Disc disc;
  std::size_t contact = 0;
};
void Divide(const std::vector<Touch>& touches, double slenderness, std::vector<ContactPart>* parts);

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
  // cannot move. `count`: rows from `contact` on that move together, as one.
  [[nodiscard]] double Stiffness(const Eigen::MatrixXd& compliance, Eigen::Index contact,
                                 Eigen::Index count = 1) const noexcept;

 private:
  std::vector<Eigen::Index> contacts_;
  Eigen::VectorXd scale_;    // 1 / sqrt of a contact's own compliance
  Eigen::MatrixXd scaled_;   // their part of the compliance, with ones on the diagonal
  Eigen::MatrixXd inverse_;  // of scaled_
  Eigen::PartialPivLU<Eigen::MatrixXd> factor_;
  Eigen::VectorXd solution_;
};

}  // namespace palpate::plate
