// The contact of one zone: where it acts, and the forces that move its points as prescribed, that
// are prescribed themselves, or that a rigid tool exerts (tool_contact.h).
#pragma once

#include <memory>
#include <optional>
#include <utility>
#include <vector>

#include <Eigen/Cholesky>
#include <Eigen/Core>

#include "slave/mechanics/fem/zone/tool_contact.h"

namespace palpate {

// Points that are each a weighted mean of nodes, numbered as in the zone.
struct ZoneContact {
  using Point = std::vector<std::pair<int, double>>;
  std::vector<Point> points;
  bool loaded = false;  // the force on its only point is prescribed
  // A rigid tool that the points, single nodes, may touch; otherwise they are moved as prescribed.
  std::optional<Tool> tool{};
  ToolContact::Placement placement{};  // of the tool
  double friction = 0;                 // Coulomb's coefficient; infinite: bonded

  [[nodiscard]] int unknowns() const { return 3 * static_cast<int>(points.size()); }
};

class ContactForces {
 public:
  // `rest`: position of every point. `compliance`: displacements of the points by forces on them.
  // Throws std::runtime_error: points that cannot be moved independently.
  ContactForces(const ZoneContact& contact, std::vector<Eigen::Vector3d> rest,
                Eigen::MatrixXd compliance);

  void Reset();
  // The forces, where the points are now, and where they would be without forces. Does not
  // allocate.
  void Solve(const Eigen::VectorXd& prescribed, const Eigen::VectorXd& now,
             const Eigen::VectorXd& free) noexcept;
  // Forces by which the contact as it is answers a displacement of the points by something else.
  void Hold(const Eigen::VectorXd& moved, Eigen::VectorXd* forces) noexcept;
  // Forces of the dual problem, three columns: by a unit motion of the contact along each axis, or
  // by a unit load with the other sign.
  [[nodiscard]] Eigen::MatrixXd DualForces() noexcept;
  // See ToolContact.
  void Accept(const Eigen::VectorXd& now) noexcept;
  // `number`: per point, that of the same point in `other`; -1: none.
  void TakeState(const ContactForces& other, const std::vector<int>& number);

  // Per point, and their sum.
  [[nodiscard]] const Eigen::VectorXd& forces() const { return forces_; }
  [[nodiscard]] Eigen::Vector3d Sum() const;
  [[nodiscard]] const ToolContact* tool() const { return tool_.get(); }

 private:
  bool loaded_;
  Eigen::MatrixXd compliance_;
  Eigen::LLT<Eigen::MatrixXd> inverse_;
  std::unique_ptr<ToolContact> tool_;
  Eigen::VectorXd forces_;
};

// Between nodes of a zone and points of its contact, three numbers each: means, and forces spread.
template <class Vector>
void TakePoints(const ZoneContact& contact, const Vector& u, Eigen::VectorXd* at) noexcept {
  for (std::size_t p = 0; p < contact.points.size(); ++p) {
    Eigen::Vector3d mean = Eigen::Vector3d::Zero();
    for (const auto& [node, weight] : contact.points[p]) {
      mean += weight * u.template segment<3>(3 * node).template cast<double>();
    }
    at->segment<3>(3 * static_cast<int>(p)) = mean;
  }
}
void SpreadForces(const ZoneContact& contact, const Eigen::VectorXd& forces,
                  Eigen::VectorXd* load) noexcept;

}  // namespace palpate
