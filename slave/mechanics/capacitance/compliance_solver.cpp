#include "slave/mechanics/capacitance/compliance_solver.h"

#include <algorithm>
#include <chrono>
#include <cmath>
#include <exception>
#include <new>
#include <numeric>
#include <tuple>

#include <Eigen/LU>

#include "shared/text/text.h"
#include "slave/mechanics/footprint/disc_compliance.h"
#include "slave/mechanics/mesh_resolution.h"
#include "slave/mesh/index.h"

namespace palpate {
namespace {

using Eigen::Matrix3d;
using Eigen::Vector3d;

constexpr double kAbsurd = 1e6;  // larger sides

// Up to this number of unknowns all columns are computed instead of only the forces, because
// further values of the same contacts are then cheaper (bench_mechanics, one to eight contacts).
constexpr int kFewColumns = 16;

ComplianceSolver::Params Checked(const ComplianceSolver::Params& params) {
  RequirePositive("young_modulus", params.young_modulus);
  RequirePositive("larger_side", params.larger_side);
  RequirePositive("range", params.range);
  return params;
}

double Dot(std::span<const double> a, std::span<const double> b) {
  return std::inner_product(a.begin(), a.end(), b.begin(), 0.0);
}

}  // namespace

ComplianceSolver::ComplianceSolver(Compliance& compliance, ContactPlaces& places,
                                   const Params& params)
    : compliance_(compliance),
      params_(Checked(params)),
      length_unit_(compliance.length_unit()),
      force_unit_(params_.young_modulus * length_unit_ *
                  (params_.thickness > 0 ? params_.thickness : length_unit_)),
      set_(compliance, places, params_.contact),
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
  // The first two repetitions compute missing columns and allocate.
  for (int i = -2; i < kTimes; ++i) {
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
  if (!columns_known_ && WantsColumns(contacts)) SolveColumns();
  if (!SetValues(contacts)) return false;
  SolveForces();
  for (int i = 0; i < static_cast<int>(contacts.size()); ++i) {
    responses[Index(i)] = ResponseOf(set_.slots()[Index(i)], contacts[Index(i)]);
    if (responses[Index(i)].validity == Validity::kFailed) {
      return Refuse("the solution is not finite or too large");
    }
  }
  return true;
}

bool ComplianceSolver::WantsColumns(std::span<const Contact> contacts) const {
  return compliance_.components() * static_cast<int>(contacts.size()) <= kFewColumns ||
         std::ranges::any_of(contacts, &Contact::wants_stiffness);
}

// Returns whether the value is finite and plausible: 1e300 m is an error, not a displacement.
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
  columns_known_ = false;
  if (outcome == ContactSet::Outcome::kFailed) return Fail(set_.failure());
  if (!FactoriseCapacitance()) {
    return Fail(
        "contacts overlap and their displacements are dependent, or they leave the body free to "
        "move");
  }
  loads_.Fill(set_);
  SoftenLoads();
  return true;
}

// Additional compliance of a contact's disc relative to the wider disc that represents it;
// nondimensional, all components.
Matrix3d ComplianceSolver::Lacking(const ContactSlot& slot) const {
  const double nu = params_.poisson_ratio;
  const DiscCompliance disc = slot.load >= 0                                 ? OfEvenLoad(nu)
                              : params_.contact == ContactLaw::kFrictionless ? OfSlidingDisc(nu)
                                                                             : OfBondedDisc(nu);
  return length_unit_ * slot.footprint.narrower * disc.Around(slot.footprint.normal_O);
}

// Reduces the displacement of the places relative to the contact by the additional compliance times
// their total force.
void ComplianceSolver::SoftenNarrow(const ContactSlot& slot) {
  if (slot.footprint.narrower == 0 || slot.load >= 0) return;
  const Matrix3d lacking = Lacking(slot);
  const auto unknowns = set_.unknowns().subspan(Index(slot.unknown), Index(slot.unknowns));
  for (const auto& at : unknowns) {
    for (const auto& by : unknowns) {
      const Matrix3d block = at.basis.transpose() * lacking * by.basis;
      double* to = factor_.row(at.row) + by.row;
      for (int r = 0; r < at.count; ++r, to += factor_.stride()) {
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

bool ComplianceSolver::FactoriseCapacitance() {
  factor_.Reset(set_.rows());
  const auto unknowns = set_.unknowns();
  for (std::size_t by = 0; by < unknowns.size(); ++by) {
    if (by + 1 < unknowns.size()) {
      for (const auto& at : unknowns) compliance_.PrefetchBlock(at, unknowns[by + 1]);
    }
    for (const auto& at : unknowns) {
      compliance_.FillBlock(at, unknowns[by], factor_.row(at.row) + unknowns[by].row,
                            factor_.stride());
    }
  }
  for (const auto& slot : set_.slots()) SoftenNarrow(slot);
  return factor_.Factorise();
}

// Adds what a contact's value prescribes to right_.
void ComplianceSolver::AddPrescribed(const ContactSlot& slot, const Vector3d& value) {
  for (int c = 0; c < compliance_.components() && slot.load >= 0; ++c) {
    const auto by = loads_.unknowns_by(slot.load, c);
    for (std::size_t r = 0; r < by.size(); ++r) right_[r * kLane8] -= value[c] * by[r];
  }
  for (const auto& u : set_.unknowns().subspan(Index(slot.unknown), Index(slot.unknowns))) {
    for (int k = 0; k < u.count; ++k) {
      right_[Index(u.row + k) * kLane8] += u.basis.col(k).dot(value);
    }
  }
}

// Fills one column per unit value that a contact prescribes.
void ComplianceSolver::FillUnitColumns(const ContactSlot& slot, double* first) const {
  for (int c = 0; c < compliance_.components() && slot.load >= 0; ++c) {
    const auto by = loads_.unknowns_by(slot.load, c);
    for (std::size_t r = 0; r < by.size(); ++r)
      first[r * Index(column_stride_) + Index(c)] = -by[r];
  }
  for (const auto& u : set_.unknowns().subspan(Index(slot.unknown), Index(slot.unknowns))) {
    for (int k = 0; k < u.count; ++k) {
      double* row = first + (u.row + k) * column_stride_;
      for (int c = 0; c < compliance_.components(); ++c) row[c] = u.basis(c, k);
    }
  }
}

// Computes the forces for unit values of every contact, and the stiffness of each.
void ComplianceSolver::SolveColumns() {
  const auto slots = set_.slots();
  const int components = compliance_.components();
  column_stride_ = PaddedTo8(components * static_cast<int>(slots.size()));
  columns_.assign(Index(set_.rows()) * Index(column_stride_), 0.0);
  for (std::size_t i = 0; i < slots.size(); ++i) {
    FillUnitColumns(slots[i], columns_.data() + Index(components) * i);
  }
  factor_.Solve({columns_.data(), column_stride_});
  columns_known_ = true;
  stiffness_.resize(slots.size());
  for (std::size_t i = 0; i < slots.size(); ++i) {
    const double* first = columns_.data() + Index(components) * i;
    stiffness_[i] =
        slots[i].load >= 0 ? StiffnessOfLoad(slots[i], first) : StiffnessOf(slots[i], first);
  }
}

// Returns the total force of the contact for a displacement of all its places.
Matrix3d ComplianceSolver::StiffnessOf(const ContactSlot& slot, const double* first) const {
  Matrix3d stiffness = Matrix3d::Zero();
  const bool planar = compliance_.components() == 2;
  for (const auto& u : set_.unknowns().subspan(Index(slot.unknown), Index(slot.unknowns))) {
    for (int k = 0; k < u.count; ++k) {
      const double* row = first + (u.row + k) * column_stride_;
      const Vector3d by(row[0], row[1], planar ? 0 : row[2]);
      stiffness += u.measure * u.basis.col(k) * by.transpose();
    }
  }
  return stiffness;
}

// Returns the inverse of the compliance under a load while the contacts are fixed.
Matrix3d ComplianceSolver::StiffnessOfLoad(const ContactSlot& slot, const double* first) const {
  Matrix3d own = loads_.between(slot.load, slot.load);
  for (int r = 0; r < 3; ++r) {
    const auto at = loads_.load_by_unknowns(slot.load, r);
    for (int c = 0; c < compliance_.components(); ++c) {
      for (std::size_t k = 0; k < at.size(); ++k) {
        own(r, c) += at[k] * first[k * Index(column_stride_) + Index(c)];
      }
    }
  }
  for (int c = 0; c < 3; ++c) {  // a fixed component has zero displacement and an unknown stiffness
    if (slot.held[Index(c)]) own(c, c) = 1;
  }
  Matrix3d stiffness = own.inverse();
  for (int c = 0; c < 3; ++c) {
    if (slot.held[Index(c)]) stiffness(c, c) = 0;
  }
  return stiffness;
}

bool ComplianceSolver::MovesWhatIsHeld(const ContactSlot& slot, const Contact& contact) const {
  Vector3d value = contact.prescribed_O;
  if (slot.load < 0 && params_.contact == ContactLaw::kFrictionless) {
    value = slot.footprint.normal_O * slot.footprint.normal_O.dot(value);
  }
  for (int c = 0; c < 3; ++c) {
    if (slot.held[Index(c)] && value[c] != 0) return true;
  }
  return false;
}

bool ComplianceSolver::SetValues(std::span<const Contact> contacts) {
  const auto slots = set_.slots();
  const std::size_t components = Index(compliance_.components());
  values_.resize(components * slots.size());
  for (std::size_t i = 0; i < slots.size(); ++i) {
    if (MovesWhatIsHeld(slots[i], contacts[i])) {
      return Refuse("a fixed point is moved or loaded");
    }
    const double unit = slots[i].load >= 0 ? force_unit_ : length_unit_;
    for (std::size_t c = 0; c < components; ++c) {
      values_[components * i + c] = contacts[i].prescribed_O[static_cast<int>(c)] / unit;
    }
  }
  return true;
}

void ComplianceSolver::SolveForces() {
  const int rows = set_.rows();
  forces_.resize(Index(rows));
  if (columns_known_) {
    const auto count = static_cast<Eigen::Index>(values_.size());
    const Eigen::Map<const Eigen::VectorXd> values(values_.data(), count);
    for (int r = 0; r < rows; ++r) {
      const double* row = columns_.data() + Index(r) * Index(column_stride_);
      forces_[Index(r)] = values.dot(Eigen::Map<const Eigen::VectorXd>(row, count));
    }
    return;
  }
  right_.assign(Index(rows) * kLane8, 0.0);
  for (std::size_t i = 0; i < set_.slots().size(); ++i) {
    AddPrescribed(set_.slots()[i], Value(i));
  }
  factor_.Solve({right_.data(), kLane8});
  for (std::size_t r = 0; r < forces_.size(); ++r) forces_[r] = right_[r * kLane8];
}

// The value of a contact, with zeros beyond the components.
Vector3d ComplianceSolver::Value(std::size_t contact) const {
  const int components = compliance_.components();
  Vector3d value = Vector3d::Zero();
  value.head(components) =
      Eigen::Map<const Eigen::VectorXd>(values_.data() + Index(components) * contact, components);
  return value;
}

Vector3d ComplianceSolver::ForceOf(const ForceUnknown& unknown) const {
  Vector3d force = Vector3d::Zero();
  for (int k = 0; k < unknown.count; ++k) {
    force += unknown.measure * forces_[Index(unknown.row + k)] * unknown.basis.col(k);
  }
  return force;
}

Vector3d ComplianceSolver::DisplacementOfLoad(int load) const {
  Vector3d displacement = Vector3d::Zero();
  for (std::size_t i = 0; i < set_.slots().size(); ++i) {
    const int by = set_.slots()[i].load;
    if (by >= 0) displacement += loads_.between(load, by) * Value(i);
  }
  for (int c = 0; c < 3; ++c) {
    displacement[c] += Dot(loads_.load_by_unknowns(load, c), forces_);
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
  const double deflection = response.displacement_O.norm() / params_.larger_side;
  const bool known =
      response.force_O.allFinite() && response.stiffness_O.allFinite() && deflection <= kAbsurd;
  if (!known) return {};
  const bool coarse =
      IsContactCoarse(slot.footprint.patch_error, params_.young_modulus * slot.contact.width,
                      response.force_O, response.displacement_O);
  const bool is_valid = deflection <= params_.range && !coarse && !slot.on_support;
  response.validity = is_valid ? Validity::kValid : Validity::kExtrapolated;
  response.takes_width = slot.footprint.narrower != 0;
  if (coarse) response.flag_reason = kCoarsePatch;
  if (slot.on_support) response.flag_reason = kOnSupport;
  SetMomentOf(slot, &response);
  return response;
}

void ComplianceSolver::SetMomentOf(const ContactSlot& slot, ContactResponse* response) const {
  const auto& [places, arms] = std::tie(slot.footprint.places, slot.footprint.arms);
  if (slot.load >= 0) {
    const Vector3d& force = response->force_O;
    const auto share = [&](std::size_t i) -> Vector3d { return places[i].weight * force; };
    return SetMoment(arms, slot.contact.width, share, response, params_.moment);
  }
  // A place fixed by a support has no unknown.
  if (Index(slot.unknowns) != arms.size()) return;
  const auto force_at = [&](std::size_t i) -> Vector3d {
    return force_unit_ * ForceOf(set_.unknowns()[Index(slot.unknown) + i]);
  };
  SetMoment(arms, slot.contact.width, force_at, response, params_.moment);
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
  for (std::size_t i = 0; i < set_.slots().size(); ++i) {
    const ContactSlot& slot = set_.slots()[i];
    if (slot.load < 0) continue;
    for (const auto& [place, weight] : slot.footprint.places) {
      forces->push_back({place, weight * force_unit_ * Value(i)});
    }
  }
}

}  // namespace palpate
