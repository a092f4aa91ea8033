#include "slave/mechanics/fem/zone/zone_set.h"

#include <stdexcept>

#include "shared/geometry/index.h"

namespace palpate {
namespace {

using Eigen::MatrixXd;
using Eigen::Vector3d;
using Eigen::VectorXd;

}  // namespace

ZoneSet::ZoneSet(const ZonePlaces& places, std::vector<Touch> touches) {
  members_.reserve(touches.size());
  std::vector<char> inside(places.mesh().tets.size(), 0);
  for (const Touch& touch : touches) {
    members_.emplace_back(*touch.place, touch.contact);
    for (const int t : touch.place->body.zone.tets) inside[Index(t)] = 1;
  }
  std::vector<std::array<int, 4>> outside;
  for (std::size_t t = 0; t < inside.size(); ++t) {
    if (inside[t] == 0) outside.push_back(places.mesh().tets[t]);
  }
  outside_.emplace(outside, places.positions(), places.nu());
  for (Member& member : members_) Couple(&member);
  Reset();
  if (!Refresh()) throw std::runtime_error("a zone cannot be factored");
}

// The others' modes as loads: v moves the zone's border and its linear tetrahedra alike, so that
// h = S_rest v_b + K_zone v.
void ZoneSet::Couple(Member* member) const {
  const ZoneBody& body = member->place.body;
  const Zone& zone = body.zone;
  const int border = 3 * zone.border();
  member->load = VectorXd::Zero(3 * zone.size());
  member->incoming = VectorXd::Zero(border);
  for (const Member& other : members_) {
    const int modes = &other == member ? 0 : static_cast<int>(other.place.far.cols());
    MatrixXd moved(3 * zone.size(), modes), load = MatrixXd::Zero(3 * zone.size(), modes);
    for (int n = 0; n < zone.size(); ++n) {
      moved.middleRows<3>(3 * n) =
          other.place.far.block(3 * zone.nodes[Index(n)], 0, 3, modes).cast<double>();
    }
    for (int k = 0; k < modes; ++k) {
      member->solver.LinearForce(moved.col(k), &member->load);
      load.col(k) = member->load;
    }
    member->load_by.push_back(std::move(load));
    member->moved_by.emplace_back(moved.bottomRows(border));
  }
}

void ZoneSet::Reset() {
  for (Member& member : members_) {
    member.solver.Reset();
    member.amplitudes = VectorXd::Zero(member.place.to_modes.rows());
    member.incoming.setZero();
  }
}

bool ZoneSet::Refresh() {
  bool all = true;
  for (Member& member : members_) {
    if (member.tangent.Compute(member.solver.u())) {
      FindDual(&member);
    } else {
      all = false;
    }
  }
  return all;
}

void ZoneSet::FindDual(Member* member) const {
  const MatrixXd& columns = member->tangent.columns();
  MatrixXd forces = Vector3d::Ones().asDiagonal().toDenseMatrix().replicate(columns.cols() / 3, 1);
  forces = member->tangent.compliance().solve(forces);
  const int border = static_cast<int>(member->place.to_modes.cols());
  member->dual = member->place.to_modes * (columns.bottomRows(border) * forces);
}

// Of what this zone itself does to the body.
void ZoneSet::TakeAmplitudes(Member* member) noexcept {
  const int border = static_cast<int>(member->incoming.size());
  member->amplitudes.noalias() =
      member->place.to_modes * (member->solver.u().tail(border) - member->incoming);
}

void ZoneSet::Step(std::span<const VectorXd> prescribed, int sweeps) noexcept {
  for (int sweep = 0; sweep < sweeps; ++sweep) {
    for (std::size_t i = 0; i < members_.size(); ++i) {
      Member& member = members_[i];
      if (members_.size() > 1) {
        member.load.setZero();
        member.incoming.setZero();
        for (std::size_t j = 0; j < members_.size(); ++j) {
          if (i == j) continue;
          member.load.noalias() += member.load_by[j] * members_[j].amplitudes;
          member.incoming.noalias() += member.moved_by[j] * members_[j].amplitudes;
        }
        member.solver.SetLoad(member.load);
      }
      member.solver.Step(member.tangent, prescribed[i]);
      TakeAmplitudes(&member);
    }
  }
}

std::vector<Vector3d> ZoneSet::EstimateErrors() const {
  const int unknowns = static_cast<int>(members_.front().place.far.rows());
  VectorXd u = VectorXd::Zero(unknowns), linear = u, residual = u;
  for (const Member& member : members_) {
    u += (member.place.far * member.amplitudes.cast<float>()).cast<double>();
  }
  outside_->AddForce(u.data(), residual.data());
  outside_->AddLinearForce(u.data(), linear.data());
  residual -= linear;
  std::vector<Vector3d> errors;
  for (const Member& member : members_) {
    const VectorXd work = (member.place.far.transpose() * residual.cast<float>()).cast<double>();
    errors.emplace_back(member.dual.transpose() * work);
  }
  return errors;
}

}  // namespace palpate
