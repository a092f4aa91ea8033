// Contacts on one body, each in its own zone, and the error of their forces.
//
// The zones know each other through the linear body (transfer.h): the load of one moves the nodes
// of those near it, and, as forces on a few samples, the samples of the others (field_samples.h).
// What is linear outside all zones and should not be gives the error (outside_error.h).
#pragma once

#include <memory>
#include <optional>
#include <span>
#include <vector>

#include <Eigen/Core>

#include "slave/mechanics/fem/zone/outside_error.h"
#include "slave/mechanics/fem/zone/zone_part.h"

namespace palpate {

class ZoneSet {
 public:
  struct Touch {
    Eigen::Vector3d centre_O{0, 0, 0};  // of the zone [m]
    double radius = 0;                  // of the zone [m]
    std::vector<int> nodes;             // of the mesh, that the contact can touch
    // By numbers in `nodes`.
    ZoneContact contact;
  };
  // Prepares columns. Keeps references. Throws: see NearGreen::Prepare; std::runtime_error: no
  // memory for them or for so many contacts, or a zone that cannot be condensed.
  ZoneSet(NearGreen& green, const SolidMesh& mesh, double nu, const std::vector<Touch>& touches);

  // A zone moves with its contact, or grows: the state goes on. Throws as the constructor.
  void Replace(int contact, const Touch& touch);

  // How far Green's functions must reach for a zone of `radius` whose nodes are within `extent`.
  [[nodiscard]] static double ReachOf(double radius, double extent);

  // The body is at rest again.
  void Reset();
  // See ZonePart.
  void Accept() noexcept;
  void RefreshDuals() noexcept;
  void Restart();
  // One step of every zone, one after the other; what is prescribed per zone (ZonePart::Step). Does
  // not allocate.
  void Step(std::span<const Eigen::VectorXd> prescribed) noexcept;
  // Finds the errors of the present state: of contacts whose load has changed much, of the others
  // in turn, one per call at most. Nondimensional. Does not allocate.
  void EstimateErrors() noexcept;
  [[nodiscard]] const OutsideError& error(int contact) const {
    return *members_[static_cast<std::size_t>(contact)].outside;
  }
  // What the error's size is expected to stay below: that of the surroundings, and what the errors
  // of the other contacts' forces do to this one.
  [[nodiscard]] double bound(int contact) const;

  [[nodiscard]] int size() const { return static_cast<int>(members_.size()); }
  [[nodiscard]] const ZonePart& part(int contact) const {
    return *members_[static_cast<std::size_t>(contact)].part;
  }
  // Displacement of every node of the mesh, three numbers each: of the state, and by a unit motion
  // of each contact along each axis, or a load with the other sign, three columns per contact.
  [[nodiscard]] Eigen::MatrixXd Displacements();
  [[nodiscard]] Eigen::MatrixXd DualDisplacements();
  // Smallest det F in the zones.
  [[nodiscard]] double SmallestJacobian() const noexcept;

 private:
  struct Source {
    std::size_t from = 0;
    bool near = false;  // from every node to every node, else from samples to samples
    Transfer transfer;
    double gain = 0;  // of this contact's force by a force of the other one
  };
  struct Member {
    std::unique_ptr<ZonePart> part;
    std::unique_ptr<OutsideError> outside;
    std::vector<Source> sources;
    double estimated_at = 0;          // size of the load at the last estimate
    Eigen::VectorXd samples, others;  // displacement by other zones: of the samples, of the zone
  };
  std::unique_ptr<ZonePart> MakePart(std::size_t contact);
  void Connect();
  void Couple(std::size_t to);
  [[nodiscard]] Eigen::VectorXd DisplacementAt(const std::vector<int>& nodes, std::size_t contact);
  void FindGains();
  [[nodiscard]] static double OwnBound(const Member& member);
  void TakeOthers(Member* member) noexcept;

  NearGreen& green_;
  const SolidMesh& mesh_;
  double nu_;
  ZoneFinder finder_;
  std::vector<Touch> touches_;
  std::vector<char> taken_;  // tetrahedra of zones
  std::vector<Member> members_;
  std::size_t turn_ = 0;  // whose error is estimated next
};

}  // namespace palpate
