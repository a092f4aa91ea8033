#include "slave/mechanics/capacitance/compliance_solver.h"

#include <algorithm>
#include <chrono>
#include <cmath>
#include <exception>
#include <new>
#include <tuple>

#include <Eigen/LU>

#include "shared/geometry/index.h"
#include "shared/text/text.h"
#include "slave/mechanics/footprint/disc_compliance.h"
#include "slave/mechanics/mesh_resolution.h"

namespace palpate {
namespace {

using Eigen::Matrix3d;
using Eigen::Vector3d;

constexpr double kAbsurd = 1e6;  // larger sides
// Fresh factors against rows that go and come one by one; measured, not counted.
constexpr int kUpdateRows = 8;
// Stiffness from three solutions per contact against triangles that are inverted; measured.
constexpr int kRowsPerContact = 20;

ComplianceSolver::Params Checked(const ComplianceSolver::Params& params) {
  RequirePositive("young_modulus", params.young_modulus);
  RequirePositive("larger_side", params.larger_side);
  RequirePositive("range", params.range);
  return params;
}

double Dot(const double* a, const double* b, int count) {
  double sum = 0;
  for (int i = 0; i < count; ++i) sum += a[i] * b[i];
  return sum;
}

}  // namespace

ComplianceSolver::ComplianceSolver(Compliance& compliance, ContactPlaces& places,
                                   const Params& params)
    : compliance_(compliance),
      params_(Checked(params)),
      length_unit_(compliance.length_unit()),
      force_unit_(params_.young_modulus * length_unit_ * length_unit_),
      set_(compliance, places, params_.contact),
      inverse_(compliance.symmetric()),
      loads_(compliance) {}

void ComplianceSolver::Respond(std::span<const Contact> contacts,
                               std::span<ContactResponse> responses) noexcept {
  failure_ = {};
  try {
    answered_ = responses.size() == contacts.size() && TryRespond(contacts, responses);
  } catch (const std::bad_alloc&) {
    answered_ = Fail("out of memory");
  } catch (const std::exception&) {
    answered_ = Fail("the Green's functions of a contact point could not be computed");
  }
  if (!answered_) std::ranges::fill(responses, ContactResponse{});
}

double ComplianceSolver::MeasureUpdate(Compliance& compliance, ContactPlaces& places,
                                       const Params& params,
                                       const std::array<Contact, 2>& contacts) {
  ComplianceSolver solver(compliance, places, params);
  ContactResponse response;
  constexpr int kTimes = 1000;
  std::chrono::steady_clock::time_point start;
  for (int i = -2; i < kTimes; ++i) {  // the first two compute what is missing and make room
    if (i == 0) start = std::chrono::steady_clock::now();
    solver.Respond({&contacts[Index(i & 1)], 1}, {&response, 1});
    if (response.validity == Validity::kFailed) return 0;
  }
  return 1e6 * SecondsSince(start) / kTimes;
}

bool ComplianceSolver::Refuse(std::string_view why) {
  failure_ = why;
  return false;
}

bool ComplianceSolver::Fail(std::string_view why) {
  set_.Forget();
  return Refuse(why);
}

bool ComplianceSolver::TryRespond(std::span<const Contact> contacts,
                                  std::span<ContactResponse> responses) {
  for (const auto& contact : contacts) {
    if (!Acceptable(contact)) return Refuse("a value is not finite or too large");
  }
  if (!Prepare(contacts)) return false;
  if (!stiffness_known_ && std::ranges::any_of(contacts, &Contact::wants_stiffness)) {
    FillStiffness();
  }
  if (!Prescribe(contacts)) return false;
  if (set_.rows() > 0) inverse_.Solve(prescribed_.get(), forces_.get());
  for (int i = 0; i < static_cast<int>(contacts.size()); ++i) {
    responses[Index(i)] = ResponseOf(set_.slots()[Index(i)], contacts[Index(i)]);
    if (responses[Index(i)].validity == Validity::kFailed) {
      return Refuse("the solution is not finite or too large");
    }
  }
  return true;
}

// Finite, and not absurdly large: 1e300 m is a fault, not a displacement.
bool ComplianceSolver::Acceptable(const Contact& contact) const noexcept {
  const bool moved = contact.kind == Contact::Kind::kDisplacement;
  const double largest = kAbsurd * (moved ? params_.larger_side : force_unit_);
  return contact.prescribed_O.cwiseAbs().maxCoeff() <= largest &&
         contact.prescribed_O.allFinite() && contact.width >= 0 && std::isfinite(contact.width) &&
         contact.p_O.allFinite() && contact.element >= -1;
}

bool ComplianceSolver::Prepare(std::span<const Contact> contacts) {
  const auto outcome = set_.Update(contacts);
  if (outcome == ContactSet::Outcome::kSame) return true;
  stiffness_known_ = false;
  if (outcome == ContactSet::Outcome::kFailed) return Fail(set_.failure());
  const bool little = outcome == ContactSet::Outcome::kChanged && LittleChanged();
  const bool changed = little && inverse_.inverted() && InvertChanged();
  if (!changed && !AnswerAgain(little)) {
    return Fail("contacts overlap: their prescribed displacements are dependent");
  }
  if (inverse_.padded() > vector_room_) {
    vector_room_ = inverse_.padded() + inverse_.padded() / 4;
    for (auto* array : {&prescribed_, &forces_, &scratch_}) {
      *array = MakeAligned(Index(PaddedTo8(vector_room_)));
    }
  }
  if (!loads_.Fill(set_, inverse_.padded())) {
    return Fail("the Green's functions of a loaded point are not stored: their memory is used up");
  }
  SoftenLoads();
  return true;
}

// By how much the disc of a contact gives way more than the wider one that stands for it:
// nondimensional, all components.
Matrix3d ComplianceSolver::Lacking(const ContactSlot& slot) const {
  const double nu = params_.poisson_ratio;
  const DiscCompliance disc = slot.load >= 0                                 ? OfEvenLoad(nu)
                              : params_.contact == ContactLaw::kFrictionless ? OfSlidingDisc(nu)
                                                                             : OfBondedDisc(nu);
  return length_unit_ * slot.footprint.narrower * disc.Around(slot.footprint.normal_O);
}

// The places move by so much less than the contact as all their forces together make it.
void ComplianceSolver::SoftenNarrow(const ContactSlot& slot, bool lower_half) {
  if (slot.footprint.narrower == 0 || slot.load >= 0) return;
  const Matrix3d lacking = Lacking(slot);
  const auto unknowns = set_.unknowns().subspan(Index(slot.unknown), Index(slot.unknowns));
  for (const auto& at : unknowns) {
    for (const auto& by : unknowns) {
      if (lower_half && at.row < by.row) continue;
      const Matrix3d block = at.basis.transpose() * lacking * by.basis;
      double* to = inverse_.row(at.row) + by.row;
      for (int r = 0; r < at.count; ++r, to += inverse_.stride()) {
        for (int c = 0; c < by.count; ++c) to[c] += block(r, c);
      }
    }
  }
}

void ComplianceSolver::SoftenLoads() {
  for (const auto& slot : set_.slots()) {
    if (slot.load >= 0 && slot.footprint.narrower != 0) loads_.Soften(slot.load, Lacking(slot));
  }
}

// Factors where everything is new; the inverse where little changes, so that the next change, which
// may be as small, finds it.
bool ComplianceSolver::AnswerAgain(bool little_changed) {
  inverse_.Reset(set_.rows());
  const auto unknowns = set_.unknowns();
  const bool symmetric = compliance_.symmetric();
  for (std::size_t by = 0; by < unknowns.size(); ++by) {
    const std::size_t first = symmetric ? by : 0;
    if (by + 1 < unknowns.size()) {
      for (std::size_t at = symmetric ? by + 1 : 0; at < unknowns.size(); ++at) {
        PrefetchBlock(unknowns[at], unknowns[by + 1]);
      }
    }
    for (std::size_t at = first; at < unknowns.size(); ++at) {
      FillBlock(unknowns[at], unknowns[by], inverse_.row(unknowns[at].row) + unknowns[by].row,
                inverse_.stride());
    }
  }
  for (const auto& slot : set_.slots()) SoftenNarrow(slot, symmetric);
  return little_changed ? inverse_.Invert() : inverse_.Factorise();
}

bool ComplianceSolver::LittleChanged() const {
  int rows = 0;
  for (const auto& change : set_.changes()) rows += change.removed + change.inserted;
  return rows * kUpdateRows <= set_.rows();
}

bool ComplianceSolver::InvertChanged() {
  for (const auto& change : set_.changes()) {
    if (!inverse_.Splice(change.row, change.removed, change.inserted)) return false;
  }
  const auto unknowns = set_.unknowns();
  for (const auto& change : set_.changes()) {
    const auto changed = unknowns.subspan(Index(change.unknown), Index(change.unknowns));
    for (const auto& at : changed) {
      for (const auto& by : unknowns) PrefetchBlock(by, at);
      for (const auto& by : unknowns) {
        double* to = inverse_.row(at.row) + by.row;
        if (compliance_.symmetric()) {
          FillBlockBySymmetry(at, by, to, inverse_.stride());
        } else {
          FillBlock(at, by, to, inverse_.stride());
          FillBlock(by, at, inverse_.row(by.row) + at.row, inverse_.stride());
        }
      }
    }
    for (const auto& slot : set_.slots().subspan(Index(change.slot), Index(change.slots))) {
      SoftenNarrow(slot, false);
    }
    if (!inverse_.Border(change.row, change.inserted)) return false;
  }
  return inverse_.Settle();
}

void ComplianceSolver::FillStiffness() {
  stiffness_known_ = true;
  const auto slots = set_.slots();
  stiffness_.resize(slots.size());
  const int contacts = static_cast<int>(slots.size()) - set_.loads();
  const bool by_solving = !inverse_.inverted() && contacts * kRowsPerContact <= set_.rows();
  if (contacts > 0 && !by_solving) inverse_.PrepareBlocks();
  for (std::size_t i = 0; i < slots.size(); ++i) {
    stiffness_[i] = slots[i].load >= 0 ? StiffnessOfLoad(slots[i])
                    : by_solving       ? StiffnessBySolving(slots[i])
                                       : StiffnessByBlocks(slots[i]);
  }
}

// All forces of the contact by a displacement of all its places.
Matrix3d ComplianceSolver::StiffnessBySolving(const ContactSlot& slot) {
  Matrix3d stiffness = Matrix3d::Zero();
  const auto unknowns = set_.unknowns().subspan(Index(slot.unknown), Index(slot.unknowns));
  std::fill_n(prescribed_.get(), inverse_.padded(), 0.0);
  for (int c = 0; c < 3; ++c) {
    for (const auto& u : unknowns) {
      for (int k = 0; k < u.count; ++k) prescribed_[Index(u.row + k)] = u.basis(c, k);
    }
    inverse_.Solve(prescribed_.get(), scratch_.get());
    for (const auto& u : unknowns) {
      for (int k = 0; k < u.count; ++k) {
        stiffness.col(c) += scratch_[Index(u.row + k)] * u.basis.col(k);
      }
    }
  }
  return stiffness;
}

// The same as a sum of the inverse's blocks.
Matrix3d ComplianceSolver::StiffnessByBlocks(const ContactSlot& slot) const {
  Matrix3d sum = Matrix3d::Zero();
  const auto unknowns = set_.unknowns().subspan(Index(slot.unknown), Index(slot.unknowns));
  for (const auto& at : unknowns) {
    for (const auto& by : unknowns) {
      Eigen::Matrix<double, 3, 3, Eigen::RowMajor> block;
      inverse_.InverseBlock(at.row, by.row, block.data());
      if (at.plain && by.plain) {
        sum += block;
      } else {
        sum += at.basis.leftCols(at.count) * block.topLeftCorner(at.count, by.count) *
               by.basis.leftCols(by.count).transpose();
      }
    }
  }
  return sum;
}

// Inverse of the load's own compliance with the contacts kept in place.
Matrix3d ComplianceSolver::StiffnessOfLoad(const ContactSlot& slot) {
  Matrix3d own = loads_.between(slot.load, slot.load);
  const int rows = set_.rows();
  for (int c = 0; c < 3 && rows > 0; ++c) {
    inverse_.Solve(loads_.unknowns_by(slot.load, c), scratch_.get());
    for (int r = 0; r < 3; ++r) {
      own(r, c) -= Dot(loads_.load_by_unknowns(slot.load, r), scratch_.get(), rows);
    }
  }
  for (int c = 0; c < 3; ++c) {  // a held component moves by nothing, and no stiffness is known
    if (!(loads_.between(slot.load, slot.load)(c, c) > 0)) own(c, c) = 1;
  }
  Matrix3d stiffness = own.inverse();
  for (int c = 0; c < 3; ++c) {
    if (!(loads_.between(slot.load, slot.load)(c, c) > 0)) stiffness(c, c) = 0;
  }
  return stiffness;
}

bool ComplianceSolver::MovesWhatIsHeld(const ContactSlot& slot, const Contact& contact) const {
  Vector3d value = contact.prescribed_O;
  if (slot.load < 0 && params_.contact == ContactLaw::kFrictionless) {
    value = slot.footprint.normal_O * slot.footprint.normal_O.dot(value);
  }
  for (int c = 0; c < 3; ++c) {
    const bool held =
        slot.load < 0 ? slot.held[Index(c)] : !(loads_.between(slot.load, slot.load)(c, c) > 0);
    if (held && value[c] != 0) return true;
  }
  return false;
}

bool ComplianceSolver::Prescribe(std::span<const Contact> contacts) {
  load_forces_.resize(Index(set_.loads()));
  const auto slots = set_.slots();
  for (std::size_t i = 0; i < slots.size(); ++i) {
    const ContactSlot& slot = slots[i];
    if (MovesWhatIsHeld(slot, contacts[i])) {
      return Refuse("a fixed point is moved or loaded");
    }
    if (slot.load >= 0) {
      load_forces_[Index(slot.load)] = contacts[i].prescribed_O / force_unit_;
      continue;
    }
    const Vector3d moved = contacts[i].prescribed_O / length_unit_;
    for (const auto& u : set_.unknowns().subspan(Index(slot.unknown), Index(slot.unknowns))) {
      for (int k = 0; k < u.count; ++k) {
        prescribed_[Index(u.row + k)] = u.plain ? moved[k] : u.basis.col(k).dot(moved);
      }
    }
  }
  const int rows = set_.rows();
  std::fill(prescribed_.get() + rows, prescribed_.get() + inverse_.padded(), 0.0);
  for (int load = 0; load < set_.loads(); ++load) {
    for (int c = 0; c < 3; ++c) {
      const double force = load_forces_[Index(load)][c];
      const double* by = loads_.unknowns_by(load, c);
      for (int r = 0; r < rows; ++r) prescribed_[Index(r)] -= force * by[r];
    }
  }
  return true;
}

Vector3d ComplianceSolver::ForceOf(const ForceUnknown& unknown) const {
  if (unknown.plain) return Eigen::Map<const Vector3d>(forces_.get() + unknown.row);
  Vector3d force = Vector3d::Zero();
  for (int k = 0; k < unknown.count; ++k) {
    force += forces_[Index(unknown.row + k)] * unknown.basis.col(k);
  }
  return force;
}

Vector3d ComplianceSolver::DisplacementOfLoad(int load) const {
  Vector3d displacement = Vector3d::Zero();
  for (int by = 0; by < set_.loads(); ++by) {
    displacement += loads_.between(load, by) * load_forces_[Index(by)];
  }
  for (int c = 0; c < 3; ++c) {
    displacement[c] += Dot(loads_.load_by_unknowns(load, c), forces_.get(), set_.rows());
  }
  return displacement;
}

ContactResponse ComplianceSolver::ResponseOf(const ContactSlot& slot,
                                             const Contact& contact) const {
  ContactResponse response;
  response.force_O = contact.prescribed_O;
  response.displacement_O = contact.prescribed_O;
  if (slot.load >= 0) {
    response.displacement_O = length_unit_ * DisplacementOfLoad(slot.load);
  } else {
    Vector3d force = Vector3d::Zero();
    for (const auto& u : set_.unknowns().subspan(Index(slot.unknown), Index(slot.unknowns))) {
      force += ForceOf(u);
    }
    response.force_O = force_unit_ * force;
  }
  if (contact.wants_stiffness) {
    response.stiffness_O = (force_unit_ / length_unit_) *
                           stiffness_[static_cast<std::size_t>(&slot - set_.slots().data())];
  }
  const double deflection = (response.displacement_O / params_.larger_side).norm();
  const bool known =
      response.force_O.allFinite() && response.stiffness_O.allFinite() && deflection <= kAbsurd;
  if (!known) return {};
  const bool coarse = slot.footprint.coarse;
  const bool is_valid = deflection <= params_.range && !coarse && !slot.on_support;
  response.validity = is_valid ? Validity::kValid : Validity::kExtrapolated;
  response.takes_width = slot.footprint.narrower != 0;
  if (coarse) response.doubt = kCoarsePatch;
  if (slot.on_support) response.doubt = kOnSupport;
  SetMomentOf(slot, &response);
  return response;
}

void ComplianceSolver::SetMomentOf(const ContactSlot& slot, ContactResponse* response) const {
  const auto& [places, arms] = std::tie(slot.footprint.places, slot.footprint.arms);
  if (slot.load >= 0) {
    const Vector3d& force = response->force_O;
    const auto share = [&](std::size_t i) -> Vector3d { return places[i].weight * force; };
    return SetMoment(arms, slot.contact.width, share, response);
  }
  // A place that a support holds has no unknown.
  if (Index(slot.unknowns) != arms.size()) return;
  const auto force_at = [&](std::size_t i) -> Vector3d {
    return force_unit_ * ForceOf(set_.unknowns()[Index(slot.unknown) + i]);
  };
  SetMoment(arms, slot.contact.width, force_at, response);
}

void ComplianceSolver::Forces(std::vector<PlaceForce>* forces) const {
  forces->clear();
  if (!answered_) return;
  for (const auto& u : set_.unknowns()) {
    const Vector3d force = force_unit_ * ForceOf(u);
    for (int s = 0; s < u.share_count; ++s) {
      forces->push_back({u.shares[Index(s)].place, u.shares[Index(s)].weight * force});
    }
  }
  for (const auto& slot : set_.slots()) {
    if (slot.load < 0) continue;
    const Vector3d force = force_unit_ * load_forces_[Index(slot.load)];
    for (const auto& [place, weight] : slot.footprint.places) {
      forces->push_back({place, weight * force});
    }
  }
}

void ComplianceSolver::Displacement(std::vector<Vector3d>* displacement_O) {
  displacement_O->assign(Index(compliance_.places()), Vector3d::Zero());
  std::vector<PlaceForce> forces;
  Forces(&forces);
  for (const auto& [place, force_O] : forces) {
    const double* column = compliance_.Column(place);
    const Vector3d moved = force_O * (length_unit_ / force_unit_);
    for (int i = 0; i < compliance_.places(); ++i) {
      (*displacement_O)[Index(i)] += BlockAt(column, i) * moved;
    }
  }
}

}  // namespace palpate
