// Contacts on one body, each in its own zone, and the error of their forces.
//
// The zones know each other through the linear body: the modes of one zone's border move the others
// (zone_place.h). What is linear outside all zones and should not be gives the error
// (outside_error.h).
#pragma once

#include <optional>
#include <span>
#include <vector>

#include <Eigen/Core>

#include "slave/mechanics/fem/zone/outside_error.h"
#include "slave/mechanics/fem/zone/zone_place.h"

namespace palpate {

class ZoneSet {
 public:
  struct Touch {
    const ZonePlace* place = nullptr;
    ZoneContact contact;
  };
  // Keeps references to the places. Takes all memory, computes tangents at rest. Throws
  // std::runtime_error: one cannot be factored.
  ZoneSet(const ZonePlaces& places, const std::vector<Touch>& touches);

  // The body is at rest again.
  void Reset();
  // One step of every zone, one after the other; what is prescribed per zone (ZoneSolver::Step).
  // Does not allocate.
  void Step(std::span<const Eigen::VectorXd> prescribed) noexcept;
  // New tangents at the present state. False: one cannot be factored, and stays.
  bool Refresh();
  // Finds the errors of the present state: of the force, or of a load's mean displacement.
  // Nondimensional. Does not allocate.
  void EstimateErrors() noexcept;
  // True value minus value, to first order in the residual.
  [[nodiscard]] const Eigen::Vector3d& error(int contact) const {
    return members_[static_cast<std::size_t>(contact)].error;
  }
  // What its size is expected to stay below: the first order, and by how much the estimate changes
  // where the displacement outside is corrected by it.
  [[nodiscard]] double bound(int contact) const {
    const Member& member = members_[static_cast<std::size_t>(contact)];
    return member.error.norm() + (member.second - member.error).norm();
  }

  [[nodiscard]] int size() const { return static_cast<int>(members_.size()); }
  [[nodiscard]] const ZoneSolver& solver(int contact) const {
    return members_[static_cast<std::size_t>(contact)].solver;
  }
  // Displacement of every node of the mesh, three numbers each: of the state, and by a unit motion
  // or load of a contact alone.
  [[nodiscard]] Eigen::VectorXd Displacements() const;
  [[nodiscard]] Eigen::VectorXd DualDisplacement(int contact, int axis) const;
  // Smallest det F in the zones.
  [[nodiscard]] double SmallestJacobian() const noexcept;

 private:
  // What the modes of another zone do to this one: `from` its amplitudes a few numbers, which make
  // the load and the displacement of the border.
  struct Coupling {
    Eigen::MatrixXd from, load, moved;
    Eigen::VectorXd amounts;
  };
  struct Member {
    explicit Member(const Touch& touch)
        : place(*touch.place),
          tangent(place.body, touch.contact),
          solver(place.body, touch.contact) {}
    const ZonePlace& place;
    ZoneTangent tangent;
    ZoneSolver solver;
    Eigen::VectorXd amplitudes;        // of the modes that this contact causes
    Eigen::VectorXd incoming, border;  // displacement of the border by the others, by this contact
    Eigen::VectorXd load;              // what the others do to the zone
    std::vector<Coupling> couplings;   // per other zone
    Eigen::MatrixXd dual, dual_zone;   // modes and zone by a unit motion of the contact, or a load
    Eigen::MatrixXd response;  // of the amplitudes to work on the modes, the contact at rest
    Eigen::VectorXd work, corrected;
    Eigen::Vector3d error = Eigen::Vector3d::Zero(), second = error;
  };
  void Couple(Member* member) const;
  static void FindDual(Member* member);
  static void FindResponse(Member* member);
  void TakeIncoming(std::size_t to) noexcept;

  std::vector<Member> members_;
  std::optional<OutsideError> outside_;
};

}  // namespace palpate
