#include "slave/mechanics/fem/zone/zone_set.h"

#include <algorithm>
#include <cmath>
#include <stdexcept>
#include <utility>

#include "slave/mesh/index.h"

namespace palpate {
namespace {

using Eigen::MatrixXd;
using Eigen::Vector3d;
using Eigen::VectorXd;
using Eigen::VectorXf;

constexpr double kOutside = 2;  // how far around a zone errors are looked for [radii]

// Reach of Green's functions that are not interpolated [radii of a zone]: with less, fewer errors
// are within their bound. [tuned: bench_zone, Presses/1/20/0/45]
constexpr double kExact = 3.6;
// Zones that share the loads of their tetrahedra per step of few [zones]. [tuned: bench_zone:
// p99_us]
constexpr std::size_t kSharing = 2;
// Centres of zones that are near each other [sums of radii]: others are further apart than wide.
constexpr double kNear = 1.5;
constexpr int kMostPresses = 20;    // of every contact in a step
constexpr double kSettled = 1e-4;   // change of a force in the last of them, by the largest [-]
constexpr std::size_t kPieces = 2;  // of estimates per update, at most

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
  for (std::size_t i = 0; i < members_.size(); ++i) {
    Couple(i);
    members_[i].outside.reset();
  }
  FindGains();
  turn_ = 0;
}

void ZoneSet::Replace(int contact, const Touch& touch) {
  const std::size_t i = Index(contact);
  Member& member = members_[i];
  for (const int t : member.part->zone().tets) taken_[Index(t)] = 0;
  touches_[i] = touch;
  const std::unique_ptr<ZonePart> old = std::exchange(member.part, MakePart(i));
  std::vector<int> number(mesh_.nodes.size(), -1), old_number;
  const std::vector<int>& before = old->zone().nodes;
  for (std::size_t n = 0; n < before.size(); ++n) number[Index(before[n])] = static_cast<int>(n);
  for (const int node : member.part->zone().nodes) old_number.push_back(number[Index(node)]);
  Connect();
  TakeOthers(&member);
  member.part->TakeState(*old, old_number, member.others);
  ShareAll();
}

void ZoneSet::Accept() noexcept {
  for (Member& member : members_) member.part->Accept();
}

void ZoneSet::RefreshDuals() noexcept {
  for (Member& member : members_) {
    if (member.part->contact().tool) member.part->RefreshDual();
  }
  FindGains();
}

void ZoneSet::Couple(std::size_t to) {
  Member& member = members_[to];
  member.sources.clear();
  for (std::size_t j = 0; j < members_.size(); ++j) {
    if (j == to) continue;
    const double distance = (touches_[j].centre_O - touches_[to].centre_O).norm();
    const bool near = distance < kNear * (touches_[j].radius + touches_[to].radius);
    member.sources.push_back({j, ZoneCoupling(green_, *member.part, *members_[j].part, near)});
  }
  const FieldSamples& samples = member.part->samples();
  const ZoneContact& contact = member.part->contact();
  member.at_points.nodes = samples.nodes;
  member.at_points.weights.setZero(static_cast<int>(contact.points.size()), samples.weights.cols());
  for (std::size_t p = 0; p < contact.points.size(); ++p) {
    for (const auto& [node, weight] : contact.points[p]) {
      member.at_points.weights.row(static_cast<int>(p)) +=
          static_cast<float>(weight) * samples.weights.row(node);
    }
  }
  member.shared = member.samples = member.all_samples = VectorXd::Zero(samples.unknowns());
  member.sample_room = VectorXf::Zero(samples.unknowns());
  member.others = VectorXd::Zero(member.part->u().size());
  member.at_shared = member.at_others = VectorXd::Zero(contact.unknowns());
  member.room = VectorXf::Zero(member.others.size());
  member.at_room = VectorXf::Zero(member.at_others.size());
}

void ZoneSet::FindGains() {
  for (Member& member : members_) {
    for (Source& source : member.sources) source.gain = source.coupling.Gain(*member.part);
  }
}

// The residual grows with the square of the load, its own effect with the cube.
double ZoneSet::OwnBound(const Member& member) {
  const double size = member.part->load().norm();
  const double growth = size > member.estimated_at ? size / member.estimated_at : 1;
  return growth * growth * (member.first_order + growth * member.second_order);
}

double ZoneSet::bound(int contact) const {
  const Member& member = members_[Index(contact)];
  double bound = OwnBound(member);
  for (const Source& source : member.sources) {
    bound += source.gain * OwnBound(members_[source.from]);
  }
  return bound;
}

double ZoneSet::Remaining(int contact) const {
  const Member& member = members_[Index(contact)];
  double remaining = member.part->Remaining() + unsettled_;
  for (const Source& source : member.sources) remaining += source.news;
  return remaining;
}

void ZoneSet::Reset() {
  for (Member& member : members_) {
    member.part->Reset();
    member.estimated_at = member.estimating_at = 0;
    member.first_order = member.second_order = 0;
    if (member.outside) member.outside->Restart();
    for (VectorXd* v : {&member.shared, &member.samples, &member.at_shared}) {
      v->setZero();
    }
    for (Source& source : member.sources) source.news = 0;
  }
  unsettled_ = 0;
}

void ZoneSet::Begin(std::span<const VectorXd> prescribed) noexcept {
  for (std::size_t i = 0; i < members_.size(); ++i) members_[i].part->Begin(prescribed[i]);
}

void ZoneSet::ShareAll() noexcept {
  if (members_.size() == 1) return;
  for (std::size_t j = 0; j < members_.size(); ++j) Share(j);
  for (Member& member : members_) TakeShared(&member);
}

void ZoneSet::Share(std::size_t from) noexcept {
  Member& member = members_[from];
  difference_ = member.shared;
  member.part->samples().SampleForces(member.part->taken(), &member.shared);
  difference_ -= member.shared;  // the tetrahedra's loads act against r
  for (Member& other : members_) {
    for (Source& source : other.sources) {
      if (source.from != from) continue;
      moved_.setZero(other.samples.size());
      source.coupling.AddAtSamples(difference_, &moved_);
      other.samples += moved_;
      source.news = (other.part->dual().sampled_load.transpose() * moved_).norm();
    }
  }
}

void ZoneSet::TakeShared(Member* member) noexcept {
  member->at_shared.setZero();
  member->at_points.AddField(member->samples, &member->at_shared);
}

void ZoneSet::PressAll() noexcept {
  const bool alone = members_.size() == 1;
  for (int press = 0; press < kMostPresses; ++press) {
    double change = 0, size = 0;
    for (Member& member : members_) {
      member.at_room.setZero();
      for (const Source& source : member.sources) source.coupling.AddAtPoints(&member.at_room);
      member.at_others = member.at_shared + member.at_room.cast<double>();
      const Vector3d before = member.part->Force();
      member.part->Press(member.at_others);
      change = std::max(change, (member.part->Force() - before).norm());
      size = std::max(size, member.part->Force().norm());
    }
    unsettled_ = alone ? 0 : change;
    if (alone || change <= kSettled * size) return;
  }
}

void ZoneSet::TakeOthers(Member* member) noexcept {
  member->room.setZero();
  member->sample_room.setZero();
  for (const Source& source : member->sources) {
    source.coupling.AddAtNodes(&member->room, &member->sample_room);
  }
  member->others = member->room.cast<double>();
  member->all_samples = member->samples + member->sample_room.cast<double>();
  member->part->samples().AddField(member->all_samples, &member->others);
}

void ZoneSet::Step(bool all) noexcept {
  for (Member& member : members_) member.part->TakeLoads(all);
  if (all || members_.size() <= kSharing) {
    ShareAll();
  } else {
    for (std::size_t k = 0; k < kSharing; ++k) {
      Share(next_share_);
      next_share_ = (next_share_ + 1) % members_.size();
    }
    for (Member& member : members_) TakeShared(&member);
  }
  PressAll();
  for (Member& member : members_) {
    if (members_.size() > 1) TakeOthers(&member);
    member.part->Move(member.others);
  }
}

// True: the estimate is complete.
bool ZoneSet::Advance(std::size_t contact) {
  Member& member = members_[contact];
  if (!member.outside) {
    std::vector<ZonePart*> parts;
    for (const Member& other : members_) parts.push_back(other.part.get());
    const double unit = green_.length_unit(), radius = touches_[contact].radius / unit;
    member.outside = std::make_unique<OutsideError>(
        green_, mesh_, nu_, taken_, parts, contact,
        OutsideError::Region{touches_[contact].centre_O / unit, radius, kOutside * radius});
    member.estimating_at = 0;
  }
  if (member.estimating_at == 0) member.estimating_at = member.part->load().norm();
  if (!member.outside->Advance()) return false;
  member.estimated_at = member.estimating_at;
  member.estimating_at = 0;
  member.first_order = member.outside->error().norm();
  member.second_order = member.outside->second_order();
  return true;
}

void ZoneSet::EstimateErrors() {
  for (std::size_t i = 0; i < members_.size(); ++i) {
    const Member& member = members_[i];
    if (member.estimated_at > 0 || member.part->load().isZero(0)) continue;
    while (!Advance(i)) {
    }
  }
  for (std::size_t piece = 0; piece < std::min(kPieces, members_.size()); ++piece) {
    if (Advance(turn_)) turn_ = (turn_ + 1) % members_.size();
  }
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
    MatrixXd loads = MatrixXd::Zero(part(i).u().size(), 3);
    for (int c = 0; c < 3; ++c) {
      VectorXd spread = loads.col(c);
      SpreadForces(part(i).contact(), part(i).dual().forces.col(c), &spread);
      loads.col(c) = spread;
    }
    for (std::size_t n = 0; n < nodes.size(); ++n) {
      load.block<3, 3>(3 * nodes[n], 3 * i) += loads.middleRows<3>(3 * static_cast<int>(n));
    }
  }
  return green_.Solve(load);
}

double ZoneSet::SmallestJacobian() const noexcept {
  double smallest = 1;
  for (const Member& member : members_) {
    smallest = std::min(smallest, member.part->smallest_jacobian());
  }
  return smallest;
}

}  // namespace palpate
