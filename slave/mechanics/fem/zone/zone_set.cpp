#include "slave/mechanics/fem/zone/zone_set.h"

#include <algorithm>
#include <cmath>
#include <stdexcept>

#include <Eigen/LU>

#include "shared/geometry/index.h"

namespace palpate {
namespace {

using Eigen::MatrixXd;
using Eigen::Vector3d;
using Eigen::VectorXd;

constexpr double kOutside = 2;  // how far around a zone errors are looked for [radii]

// Reach of Green's functions that are not interpolated [radii of a zone]: with less, fewer errors
// are within their bound. [tuned: bench_zone, Presses/1/20/0/45]
constexpr double kExact = 3.6;
constexpr std::size_t kTurns =
    4;  // updates until the error of a contact that hardly moves is found again, at least
constexpr double kSimilar = 0.1;  // change of a load for which an estimate is scaled [-]
constexpr double kNear = 1.5;     // centres of zones that are close [sums of radii]

}  // namespace

ZoneSet::ZoneSet(NearGreen& green, const SolidMesh& mesh, double nu,
                 const std::vector<Touch>& touches)
    : green_(green),
      mesh_(mesh),
      nu_(nu),
      finder_(mesh),
      touches_(touches),
      taken_(mesh.tets.size(), 0),
      members_(touches.size()) {
  for (std::size_t i = 0; i < touches.size(); ++i) members_[i].part = MakePart(i);
  Connect();
}

std::unique_ptr<ZonePart> ZoneSet::MakePart(std::size_t contact) {
  const Touch& touch = touches_[contact];
  const double unit = green_.length_unit();
  std::vector<Vector3d> others;
  for (std::size_t j = 0; j < touches_.size(); ++j) {
    if (j != contact) others.push_back(touches_[j].centre_O);
  }
  Zone zone = finder_.Around(touch.centre_O, touch.radius, others, touch.nodes, &taken_);
  double farthest = 0;
  for (const int node : zone.nodes) {
    farthest = std::max(farthest, (green_.positions()[Index(node)] - touch.centre_O / unit).norm());
  }
  if (!green_.Prepare(zone.nodes, ReachOf(touch.radius / unit, farthest))) {
    throw std::runtime_error("no memory for the Green's functions of a zone");
  }
  return std::make_unique<ZonePart>(green_, std::move(zone), nu_, touch.contact);
}

double ZoneSet::ReachOf(double radius, double extent) {
  return std::max(extent, kExact * radius);
}

void ZoneSet::Connect() {
  std::vector<ZonePart*> parts;
  for (const Member& member : members_) parts.push_back(member.part.get());
  for (std::size_t i = 0; i < members_.size(); ++i) {
    Couple(i);
    members_[i].estimated_at = 0;
    const double unit = green_.length_unit(), radius = touches_[i].radius / unit;
    members_[i].outside = std::make_unique<OutsideError>(
        green_, mesh_, nu_, taken_, parts, i,
        OutsideError::Region{touches_[i].centre_O / unit, radius, kOutside * radius});
  }
  FindGains();
}

VectorXd ZoneSet::DisplacementAt(const std::vector<int>& nodes, std::size_t contact) {
  VectorXd u = VectorXd::Zero(3 * static_cast<int>(nodes.size()));
  for (std::size_t j = 0; j < members_.size(); ++j) {
    const ZonePart& part = *members_[j].part;
    const bool own = j == contact;
    Transfer(green_, nodes, own ? part.zone().nodes : part.samples().nodes)
        .Add(own ? part.load() : part.sampled_load(), &u);
  }
  return u;
}

void ZoneSet::Replace(int contact, const Touch& touch) {
  const std::size_t i = Index(contact);
  for (const int t : members_[i].part->zone().tets) taken_[Index(t)] = 0;
  touches_[i] = touch;
  std::unique_ptr<ZonePart> part = MakePart(i);
  std::vector<int> number(mesh_.nodes.size(), -1), old;
  const std::vector<int>& before = members_[i].part->zone().nodes;
  for (std::size_t n = 0; n < before.size(); ++n) number[Index(before[n])] = static_cast<int>(n);
  for (const int node : part->zone().nodes) old.push_back(number[Index(node)]);
  part->TakeState(*members_[i].part, old, DisplacementAt(part->zone().nodes, i));
  members_[i].part = std::move(part);
  Connect();
}

void ZoneSet::Accept() noexcept {
  for (Member& member : members_) member.part->Accept();
}

void ZoneSet::RefreshDuals() noexcept {
  for (Member& member : members_) member.part->RefreshDual();
}

void ZoneSet::Couple(std::size_t to) {
  Member& member = members_[to];
  const std::vector<int>& samples = member.part->samples().nodes;
  member.sources.clear();
  for (std::size_t j = 0; j < members_.size(); ++j) {
    if (j == to) continue;
    const ZonePart& from = *members_[j].part;
    const double distance = (touches_[j].centre_O - touches_[to].centre_O).norm();
    const bool near = distance < kNear * (touches_[j].radius + touches_[to].radius);
    member.sources.push_back({j, near,
                              near ? Transfer(green_, member.part->zone().nodes, from.zone().nodes)
                                   : Transfer(green_, samples, from.samples().nodes),
                              0});
  }
  member.samples = VectorXd::Zero(member.part->samples().unknowns());
  member.others = VectorXd::Zero(member.part->u().size());
}

// The dual load of one contact on the displacement by the other's force as it is distributed when
// that contact moves; both held otherwise.
void ZoneSet::FindGains() {
  for (Member& member : members_) {
    for (Source& source : member.sources) {
      const ZonePart& from = *members_[source.from].part;
      const MatrixXd& load = source.near ? from.dual().load : from.dual().sampled_load;
      const ZonePart::Dual& own = member.part->dual();
      const MatrixXd& test = source.near ? own.load : own.sampled_load;
      Eigen::Matrix3d total = Eigen::Matrix3d::Zero();
      MatrixXd moved = MatrixXd::Zero(test.rows(), 3);
      for (int c = 0; c < 3; ++c) {
        for (int k = 0; k < load.rows(); ++k) total(k % 3, c) += load(k, c);
        VectorXd u = moved.col(c);
        source.transfer.Add(load.col(c), &u);
        moved.col(c) = u;
      }
      const Eigen::Matrix3d caused = test.transpose() * moved;
      const bool touches = std::abs(total.determinant()) > 0;
      source.gain = touches ? (caused * total.inverse()).norm() : 0;
    }
  }
}

// The residual grows with the square of the load.
double ZoneSet::OwnBound(const Member& member) {
  const double size = member.part->load().norm();
  const double growth = size > member.estimated_at ? size / member.estimated_at : 1;
  return growth * growth * member.outside->bound();
}

double ZoneSet::bound(int contact) const {
  const Member& member = members_[Index(contact)];
  double bound = OwnBound(member);
  for (const Source& source : member.sources) {
    bound += source.gain * OwnBound(members_[source.from]);
  }
  return bound;
}

void ZoneSet::Reset() {
  for (Member& member : members_) {
    member.part->Reset();
    member.estimated_at = 0;
  }
}

void ZoneSet::Restart() {
  for (Member& member : members_) member.part->Restart();
}

void ZoneSet::TakeOthers(Member* member) noexcept {
  member->samples.setZero();
  member->others.setZero();
  for (Source& source : member->sources) {
    const ZonePart& from = *members_[source.from].part;
    source.transfer.Add(source.near ? from.load() : from.sampled_load(),
                        source.near ? &member->others : &member->samples);
  }
  member->part->samples().AddField(member->samples, &member->others);
}

void ZoneSet::Step(std::span<const VectorXd> prescribed) noexcept {
  for (std::size_t i = 0; i < members_.size(); ++i) {
    Member& member = members_[i];
    if (members_.size() > 1) TakeOthers(&member);
    member.part->Step(prescribed[i], member.others);
  }
}

void ZoneSet::EstimateErrors() noexcept {
  for (std::size_t i = 0; i < members_.size(); ++i) {
    Member& member = members_[i];
    const double size = member.part->load().norm();
    const bool changed = std::abs(size - member.estimated_at) > kSimilar * member.estimated_at;
    if (!changed && i != turn_) continue;
    member.outside->Estimate();
    member.estimated_at = size;
  }
  turn_ = (turn_ + 1) % std::max(kTurns, members_.size());
}

MatrixXd ZoneSet::Displacements() {
  MatrixXd load = MatrixXd::Zero(3 * static_cast<int>(green_.positions().size()), 1);
  for (const Member& member : members_) {
    const std::vector<int>& nodes = member.part->zone().nodes;
    for (std::size_t n = 0; n < nodes.size(); ++n) {
      load.block<3, 1>(3 * nodes[n], 0) += member.part->load().segment<3>(3 * static_cast<int>(n));
    }
  }
  return green_.Solve(load);
}

MatrixXd ZoneSet::DualDisplacements() {
  MatrixXd load = MatrixXd::Zero(3 * static_cast<int>(green_.positions().size()), 3 * size());
  for (int i = 0; i < size(); ++i) {
    const std::vector<int>& nodes = part(i).zone().nodes;
    for (std::size_t n = 0; n < nodes.size(); ++n) {
      load.block<3, 3>(3 * nodes[n], 3 * i) +=
          part(i).dual().load.middleRows<3>(3 * static_cast<int>(n));
    }
  }
  return green_.Solve(load);
}

double ZoneSet::SmallestJacobian() const noexcept {
  double smallest = 1;
  for (const Member& member : members_) {
    smallest = std::min(smallest, member.part->SmallestJacobian());
  }
  return smallest;
}

}  // namespace palpate
