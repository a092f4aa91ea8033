// Contacts on one body, each in its own zone, and the error of their forces.
//
// The zones know each other through the linear body (zone_coupling.h).
// What is linear outside all zones and should not be gives the error (outside_error.h).
#pragma once

#include <memory>
#include <optional>
#include <span>
#include <vector>

#include <Eigen/Core>

#include "slave/mechanics/fem/zone/outside_error.h"
#include "slave/mechanics/fem/zone/zone_coupling.h"
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
  // memory for them, or a zone that cannot be condensed.
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
  // Something else is prescribed, per zone. Does not allocate.
  void Begin(std::span<const Eigen::VectorXd> prescribed) noexcept;
  // One step of every zone: all of their loads, or what has changed most. The contacts are pressed
  // until they agree. Does not allocate.
  void Step(bool all) noexcept;
  // What further steps will change a contact's force by about, or a load's displacement.
  [[nodiscard]] double Remaining(int contact) const;
  // Goes on with the estimates of the contacts' errors, in turn; a first one is completed.
  // Nondimensional. Does not allocate but where a zone is new.
  void EstimateErrors();
  // From the last estimate: true value minus value, to first order.
  [[nodiscard]] const Eigen::Vector3d& error(int contact) const {
    return members_[static_cast<std::size_t>(contact)].outside->error();
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
    ZoneCoupling coupling;
    double gain = 0;  // of this contact's force by a force of the other one
    double news = 0;  // change of this contact's force by the last loads that were shared
  };
  struct Member {
    std::unique_ptr<ZonePart> part;
    std::vector<Source> sources;
    std::unique_ptr<OutsideError> outside;
    double estimated_at = 0, estimating_at = 0;  // sizes of the load at estimates
    double first_order = 0, second_order = 0;    // of the last estimate
    Eigen::VectorXd shared;  // load of the tetrahedra on the samples, as the others know it
    // Displacement by other zones: of the samples by such loads, of the points by them and by all.
    Eigen::VectorXd samples, at_shared, at_others;
    Eigen::VectorXd others;         // of the zone's nodes, by all
    FieldSamples at_points;         // the samples for the points alone
    Eigen::VectorXf room, at_room;  // of the nodes, of the points
    Eigen::VectorXf sample_room;
    Eigen::VectorXd all_samples;
  };
  std::unique_ptr<ZonePart> MakePart(std::size_t contact);
  void Connect();
  void Couple(std::size_t to);
  void FindGains();
  void ShareAll() noexcept;
  void Share(std::size_t from) noexcept;
  void TakeShared(Member* member) noexcept;
  void PressAll() noexcept;
  void TakeOthers(Member* member) noexcept;
  bool Advance(std::size_t contact);
  [[nodiscard]] static double OwnBound(const Member& member);

  NearGreen& green_;
  const SolidMesh& mesh_;
  double nu_;
  ZoneFinder finder_;
  std::vector<Touch> touches_;
  std::vector<char> taken_;  // tetrahedra of zones
  std::vector<Member> members_;
  std::size_t turn_ = 0;                // whose error is estimated
  std::size_t next_share_ = 0;          // whose loads are shared next
  double unsettled_ = 0;                // change of a force by the last press
  Eigen::VectorXd difference_, moved_;  // of samples
};

}  // namespace palpate
