#include "slave/mechanics/fem/zone/zone_set.h"

#include <algorithm>
#include <stdexcept>
#include <utility>

#include <Eigen/Eigenvalues>

#include "shared/geometry/index.h"

namespace palpate {
namespace {

using Eigen::Matrix3d;
using Eigen::MatrixXd;
using Eigen::VectorXd;

// Part of what another zone's modes do that may be left out [-].
constexpr double kUnseen = 1e-5;

}  // namespace

ZoneSet::ZoneSet(const ZonePlaces& places, const std::vector<Touch>& touches) {
  members_.reserve(touches.size());
  for (const Touch& touch : touches) members_.emplace_back(touch);
  for (Member& member : members_) Couple(&member);
  Reset();
  if (!Refresh()) throw std::runtime_error("a zone cannot be factored");
  std::vector<OutsideError::Source> sources;
  for (const Member& member : members_) sources.push_back({&member.place, &member.dual});
  outside_.emplace(places, sources);
}

// The others' modes as loads: v moves the zone's border and its linear tetrahedra alike, so that
// h = S_rest v_b + K_zone v. Far zones see few combinations of modes.
void ZoneSet::Couple(Member* member) const {
  const ZoneBody& body = member->place.body;
  const Zone& zone = body.zone;
  const int border = 3 * zone.border(), unknowns = 3 * zone.size();
  member->load = VectorXd::Zero(unknowns);
  member->incoming = member->border = VectorXd::Zero(border);
  member->amplitudes = member->work = VectorXd::Zero(member->place.to_modes.rows());
  for (const Member& other : members_) {
    const int modes = &other == member ? 0 : static_cast<int>(other.place.far.cols());
    if (modes == 0) {
      member->couplings.push_back({MatrixXd(0, other.place.far.cols()), MatrixXd(unknowns, 0),
                                   MatrixXd(border, 0), VectorXd(0)});
      continue;
    }
    MatrixXd moved(unknowns, modes);
    for (int n = 0; n < zone.size(); ++n) {
      moved.middleRows<3>(3 * n) =
          other.place.far.middleRows<3>(3 * zone.nodes[Index(n)]).cast<double>();
    }
    const Eigen::SelfAdjointEigenSolver<MatrixXd> combined(moved.transpose() * moved);
    const VectorXd& sizes = combined.eigenvalues();
    int seen = 1;
    while (seen < modes && sizes[modes - 1 - seen] > kUnseen * kUnseen * sizes[modes - 1]) ++seen;
    const MatrixXd combinations = combined.eigenvectors().rightCols(seen);
    moved = (moved * combinations).eval();
    MatrixXd load(unknowns, seen);
    for (int k = 0; k < seen; ++k) {
      member->solver.LinearForce(moved.col(k), &member->load);
      load.col(k) = member->load;
    }
    member->couplings.push_back({combinations.transpose(), std::move(load),
                                 moved.bottomRows(border), VectorXd::Zero(seen)});
  }
}

void ZoneSet::Reset() {
  for (Member& member : members_) {
    member.solver.Reset();
    member.amplitudes.setZero();
  }
}

bool ZoneSet::Refresh() {
  bool all = true;
  for (Member& member : members_) {
    if (member.tangent.Compute(member.solver.u())) {
      FindDual(&member);
      FindResponse(&member);
    } else {
      all = false;
    }
  }
  return all;
}

// A load's own dual has the other sign: its displacement falls where the body resists more.
void ZoneSet::FindDual(Member* member) {
  const MatrixXd& columns = member->tangent.columns();
  const auto border = member->place.to_modes.cols();
  if (member->solver.contact().loaded) {
    member->dual_zone = -columns;
  } else {
    const MatrixXd unit = Matrix3d::Identity().replicate(columns.cols() / 3, 1);
    member->dual_zone = columns * member->tangent.compliance().solve(unit);
  }
  member->dual = member->place.to_modes * member->dual_zone.bottomRows(border);
}

// A load w on the amplitudes acts on the border as to_modes^T w.
void ZoneSet::FindResponse(Member* member) {
  const MatrixXd& to_modes = member->place.to_modes;
  const auto modes = to_modes.rows(), border = to_modes.cols();
  const ZoneContact& contact = member->solver.contact();
  member->response.resize(modes, modes);
  VectorXd u(member->load.size()), forces(contact.unknowns());
  for (int k = 0; k < modes; ++k) {
    u.setZero();
    u.tail(border) = to_modes.row(k);
    member->tangent.Solve(&u);
    if (!contact.loaded) {
      for (std::size_t p = 0; p < contact.points.size(); ++p) {
        forces.segment<3>(3 * static_cast<int>(p)) = -MeanOf(u, contact.points[p]);
      }
      member->tangent.compliance().solveInPlace(forces);
      u.noalias() += member->tangent.columns() * forces;
    }
    member->response.col(k).noalias() = to_modes * u.tail(border);
  }
}

void ZoneSet::TakeIncoming(std::size_t to) noexcept {
  Member& member = members_[to];
  member.load.setZero();
  member.incoming.setZero();
  for (std::size_t j = 0; j < members_.size(); ++j) {
    if (j == to) continue;
    Coupling& coupling = member.couplings[j];
    coupling.amounts.noalias() = coupling.from * members_[j].amplitudes;
    member.load.noalias() += coupling.load * coupling.amounts;
    member.incoming.noalias() += coupling.moved * coupling.amounts;
  }
  member.solver.SetLoad(member.load);
}

void ZoneSet::Step(std::span<const VectorXd> prescribed) noexcept {
  for (std::size_t i = 0; i < members_.size(); ++i) {
    if (members_.size() > 1) TakeIncoming(i);
    Member& member = members_[i];
    member.solver.Step(member.tangent, prescribed[i]);
    member.border = member.solver.u().tail(member.border.size()) - member.incoming;
    member.amplitudes.noalias() = member.place.to_modes * member.border;
  }
}

void ZoneSet::EstimateErrors() noexcept {
  for (Member& member : members_) member.corrected = member.amplitudes;
  for (const bool again : {false, true}) {
    outside_->Clear();
    for (int i = 0; i < size(); ++i) outside_->Compose(i, members_[Index(i)].corrected);
    outside_->FindResidual();
    for (int i = 0; i < size(); ++i) {
      Member& member = members_[Index(i)];
      outside_->Work(i, &member.work);
      (again ? member.second : member.error).noalias() = member.dual.transpose() * member.work;
      member.corrected.noalias() -= member.response * member.work;
    }
  }
}

VectorXd ZoneSet::Displacements() const {
  VectorXd u = VectorXd::Zero(members_.front().place.far.rows());
  for (const Member& member : members_) {
    u += (member.place.far * member.amplitudes.cast<float>()).cast<double>();
  }
  for (const Member& member : members_) {
    const Zone& zone = member.place.body.zone;
    for (int n = 0; n < zone.inner; ++n) {
      u.segment<3>(3 * zone.nodes[Index(n)]) = member.solver.u().segment<3>(3 * n);
    }
  }
  return u;
}

VectorXd ZoneSet::DualDisplacement(int contact, int axis) const {
  const Member& member = members_[Index(contact)];
  VectorXd u = (member.place.far * member.dual.col(axis).cast<float>()).cast<double>();
  const Zone& zone = member.place.body.zone;
  for (int n = 0; n < zone.size(); ++n) {
    u.segment<3>(3 * zone.nodes[Index(n)]) = member.dual_zone.col(axis).segment<3>(3 * n);
  }
  return u;
}

double ZoneSet::SmallestJacobian() const noexcept {
  double smallest = 1;
  for (const Member& member : members_) {
    smallest =
        std::min(smallest, member.place.body.tets.SmallestJacobian(member.solver.u().data()));
  }
  return smallest;
}

}  // namespace palpate
