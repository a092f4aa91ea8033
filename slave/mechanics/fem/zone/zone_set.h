// Contacts on one body, each in its own zone, and the error of their forces.
//
// The zones know each other through the linear body: the modes of one zone's border move the others
// (zone_place.h). The error comes from what is linear and should not be, the tetrahedra outside all
// zones. With their residual r = f_neo-Hooke(u) - f_linear(u) at the composed displacement u and
// the displacement z by a unit motion of a contact, the other contacts at rest,
//
//   true force - force = z . r + O(r^2)
//
// a dual-weighted residual (Becker and Rannacher, Acta Numerica 10, 2001) whose dual solution is
// known: it is the contact's own response. Nothing in it is fitted.
#pragma once

#include <memory>
#include <optional>
#include <span>
#include <vector>

#include <Eigen/Core>

#include "slave/mechanics/fem/zone/zone_place.h"

namespace palpate {

class ZoneSet {
 public:
  struct Touch {
    const ZonePlace* place = nullptr;
    std::vector<int> contact;  // numbers of nodes in the zone
  };
  // Keeps references. Takes all memory, computes tangents at rest. Throws std::runtime_error: one
  // cannot be factored.
  ZoneSet(const ZonePlaces& places, std::vector<Touch> touches);

  void Reset();
  // `sweeps` steps of every zone; prescribed displacements of the contact nodes per zone. Does not
  // allocate.
  void Step(std::span<const Eigen::VectorXd> prescribed, int sweeps) noexcept;
  // New tangents at the present state. False: one cannot be factored, and stays.
  bool Refresh();

  // True force minus force, estimated, of every contact; nondimensional. O(tetrahedra).
  [[nodiscard]] std::vector<Eigen::Vector3d> EstimateErrors() const;
  [[nodiscard]] Eigen::Vector3d Force(int contact) const {
    return members_[static_cast<std::size_t>(contact)].solver.Force();
  }
  [[nodiscard]] const ZoneSolver& solver(int contact) const {
    return members_[static_cast<std::size_t>(contact)].solver;
  }

 private:
  struct Member {
    Member(const ZonePlace& at, const std::vector<int>& contact)
        : place(at), tangent(at.body, contact), solver(at.body, contact) {}
    const ZonePlace& place;
    ZoneTangent tangent;
    ZoneSolver solver;
    Eigen::VectorXd amplitudes;             // of the modes that this contact causes
    Eigen::VectorXd incoming;               // displacement of the border by the others
    Eigen::VectorXd load;                   // what the others do to the zone
    std::vector<Eigen::MatrixXd> load_by;   // per other zone: load by its modes
    std::vector<Eigen::MatrixXd> moved_by;  // the same for the border
    Eigen::MatrixXd dual;                   // modes by a unit motion of the contact
  };
  void Couple(Member* member) const;
  void FindDual(Member* member) const;
  void TakeAmplitudes(Member* member) noexcept;

  std::vector<Member> members_;
  std::optional<NeoHookeanTets> outside_;
};

}  // namespace palpate
