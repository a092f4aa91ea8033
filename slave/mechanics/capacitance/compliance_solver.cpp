#include "slave/mechanics/capacitance/compliance_solver.h"

#include <algorithm>
#include <chrono>
#include <cmath>
#include <exception>
#include <limits>
#include <new>
#include <numbers>
#include <numeric>
#include <tuple>

#include <Eigen/LU>

#include "shared/text/text.h"
#include "slave/mechanics/footprint/disc_compliance.h"
#include "slave/mechanics/footprint/rim_share.h"
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

// A place pulls or penetrates if it does by more than this part of the largest force or the depth.
constexpr double kSlack = 1e-9;
constexpr double kGuess =
    0.5;  // of the depth: largest gap of places that touch at first [by Hertz]
// Places under a round tool from which its moment is known, and its error relative to force times
// contact width divided by the number of places [-]. [derived: one place more or less at the rim,
// where the pressure is smallest]
constexpr std::size_t kFewestUnderRound = 3;
constexpr double kSpreadUnderRound = 0.5;
constexpr int kBlocks = 3;  // rounds in which all places change though no fewer are wrong
// Rounds in which places are released. A bonded place may pull where it touches and penetrate where
// it does not: it then touches. Its pull is accepted up to this part of the tool's force.
constexpr int kReleasing = 30;
constexpr double kSmallPull = 0.01;
constexpr int kMaxRounds = 100;  // of the search for the places that touch
// Error of a plane contact that ends beside the face's rim, times the square of the places that
// touch [-]. [measured: 1.1 to 1.9 % for 4 and 5, 1.3 % for 7, 0.4 to 0.7 % for 10, without
// friction, on arcs, against pressed_profile.py of the campaigns]
constexpr double kOfEdge = 0.45;

// Compliance of a boundary element's spring, times Young's modulus and the thickness [-]. The
// factor: see element_places.h.
double SpringOfElement(double poisson_ratio, double share) {
  constexpr double kLogarithm = 2.1;
  return kLogarithm * 2 / std::numbers::pi * (1 - poisson_ratio * poisson_ratio) * (1 / share - 1);
}

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
  if (!SetValues(contacts)) return false;
  if (!Settle(contacts)) {
    return Fail(
        "contacts overlap and their displacements are dependent, or they leave the body free to "
        "move");
  }
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
         contact.radius >= 0 && std::isfinite(contact.radius) && contact.p_O.allFinite() &&
         contact.element >= -1;
}

bool ComplianceSolver::Prepare(std::span<const Contact> contacts) {
  const auto outcome = set_.Update(contacts);
  if (outcome == ContactSet::Outcome::kSame) return true;
  columns_known_ = factored_ = false;
  if (outcome == ContactSet::Outcome::kFailed) return Fail(set_.failure());
  infeasible_.reserve(set_.unknowns().size());
  has_tools_ = std::ranges::any_of(set_.slots(), &ContactSlot::is_tool);
  tools_.assign(set_.slots().size(), {});
  touches_.assign(set_.unknowns().size(), 1);
  if (has_tools_) {
    whole_stride_ = PaddedTo8(set_.rows());
    whole_.assign(Index(set_.rows()) * Index(whole_stride_), 0.0);
    FillCapacitance(whole_.data(), whole_stride_);
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
void ComplianceSolver::SoftenNarrow(const ContactSlot& slot, double* first, int stride) {
  if (slot.footprint.narrower == 0 || slot.load >= 0) return;
  const Matrix3d lacking = Lacking(slot);
  for (const auto& at : UnknownsOf(slot)) {
    for (const auto& by : UnknownsOf(slot)) {
      const Matrix3d block = at.basis.transpose() * lacking * by.basis;
      double* to = first + at.row * stride + by.row;
      for (int r = 0; r < at.count; ++r, to += stride) {
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

void ComplianceSolver::FillCapacitance(double* first, int stride) {
  const auto unknowns = set_.unknowns();
  for (std::size_t by = 0; by < unknowns.size(); ++by) {
    if (by + 1 < unknowns.size()) {
      for (const auto& at : unknowns) compliance_.PrefetchBlock(at, unknowns[by + 1]);
    }
    for (const auto& at : unknowns) {
      compliance_.FillBlock(at, unknowns[by], first + at.row * stride + unknowns[by].row, stride);
    }
  }
  for (const auto& slot : set_.slots()) {
    SoftenNarrow(slot, first, stride);
    AddSprings(slot, first, stride);
  }
}

double ComplianceSolver::SpringShare(const ContactSlot& slot,
                                     const ContactResponse& response) const {
  const double work = response.force_O.dot(response.displacement_O) / (force_unit_ * length_unit_);
  if (!(work > 0) || compliance_.components() != 3) return 0;
  const Vector3d& n = slot.footprint.normal_O;
  double of_springs = 0;
  for (const auto& u : UnknownsOf(slot)) {
    const ToolHold& hold = slot.footprint.holds[Index(u.hold)];
    if (hold.share >= kWholeShare) continue;
    const double pressed = n.dot(ForceOf(u));
    of_springs += pressed * pressed * params_.springs * length_unit_ *
                  SpringAtRim(params_.poisson_ratio, hold.part_radius, hold.share).normal /
                  compliance_.modulus(u.shares[0].place);
  }
  return of_springs / work;
}

// Places of which only a part is under a flat face.
void ComplianceSolver::AddSprings(const ContactSlot& slot, double* first, int stride) const {
  if (!slot.is_tool()) return;
  for (const auto& u : UnknownsOf(slot)) {
    const ToolHold& hold = slot.footprint.holds[Index(u.hold)];
    if (hold.share >= kWholeShare) continue;
    Matrix3d spring =
        u.measure * SpringOfElement(params_.poisson_ratio, hold.share) * Matrix3d::Identity();
    if (compliance_.components() == 3) {
      spring = params_.springs * length_unit_ / compliance_.modulus(u.shares[0].place) *
               SpringAtRim(params_.poisson_ratio, hold.part_radius, hold.share)
                   .Around(slot.footprint.normal_O);
    }
    const Matrix3d block = u.basis.transpose() * spring * u.basis;
    for (int r = 0; r < u.count; ++r) {
      for (int c = 0; c < u.count; ++c) first[(u.row + r) * stride + u.row + c] += block(r, c);
    }
  }
}

bool ComplianceSolver::FactoriseTouching() {
  columns_known_ = false;
  position_.assign(Index(set_.rows()), -1);
  int rows = 0;
  for (std::size_t i = 0; i < set_.unknowns().size(); ++i) {
    const ForceUnknown& u = set_.unknowns()[i];
    for (int k = 0; k < u.count && touches_[i] != 0; ++k) position_[Index(u.row + k)] = rows++;
  }
  factor_.Reset(rows);
  if (!has_tools_) {
    FillCapacitance(factor_.row(0), factor_.stride());
    return factor_.Factorise();
  }
  for (int at = 0; at < set_.rows(); ++at) {
    if (position_[Index(at)] < 0) continue;
    const double* from = whole_.data() + at * whole_stride_;
    double* to = factor_.row(position_[Index(at)]);
    for (int by = 0; by < set_.rows(); ++by) {
      if (position_[Index(by)] >= 0) to[position_[Index(by)]] = from[by];
    }
  }
  return factor_.Factorise();
}

// Finds the forces and, with tools, the places that touch. False: the matrix is singular.
bool ComplianceSolver::Settle(std::span<const Contact> contacts) {
  factored_ = !StartTouching(contacts) && factored_;
  fewest_infeasible_ = std::numeric_limits<std::size_t>::max();
  blocks_left_ = kBlocks;
  for (int round = 0;; ++round) {
    is_settled_ = true;
    if (!factored_ && !FactoriseTouching()) return false;
    factored_ = true;
    if (!has_tools_) break;
    SolveForces();
    if (!FindInfeasible(round < kReleasing)) break;
    if (round == kMaxRounds) {
      is_settled_ = false;
      break;
    }
    SwitchInfeasible();
    factored_ = false;
  }
  if (!columns_known_ && WantsColumns(contacts)) SolveColumns();
  SolveForces();  // by the columns where they are known: the digits do not depend on the past
  return true;
}

// Updates the tools' depths. Returns true if other places touch at first than in the last answer.
bool ComplianceSolver::StartTouching(std::span<const Contact> contacts) {
  bool has_changed = false;
  for (std::size_t i = 0; i < tools_.size(); ++i) {
    const ContactSlot& slot = set_.slots()[i];
    if (!slot.is_tool()) continue;
    ToolState& tool = tools_[i];
    tool.depth = -slot.footprint.normal_O.dot(contacts[i].prescribed_O) / length_unit_;
    const bool is_round = contacts[i].radius > 0;
    double nearest = std::numeric_limits<double>::infinity();
    for (const ToolHold& hold : slot.footprint.holds) nearest = std::min(nearest, hold.gap);
    const bool presses = tool.depth > 0;
    // The places of a wider disc stand for the tool as a whole.
    const bool is_whole = slot.footprint.reach > 0;
    const Touching touching = is_whole                                         ? Touching::kAll
                              : presses && nearest < tool.depth * length_unit_ ? Touching::kSome
                              : presses || is_round                            ? Touching::kNearest
                                                                               : Touching::kAll;
    if (is_round && !presses) {
      const auto components = Index(compliance_.components());
      std::fill_n(values_.begin() + static_cast<long>(components * i), components, 0.0);
    }
    if (tool.is_known && touching == tool.touching) continue;
    tool.touching = touching;
    tool.is_known = has_changed = true;
    GuessTouching(i);
  }
  return has_changed;
}

void ComplianceSolver::GuessTouching(std::size_t contact) {
  const ContactSlot& slot = set_.slots()[contact];
  const ToolState& tool = tools_[contact];
  const auto& holds = slot.footprint.holds;
  const auto nearest =
      static_cast<int>(std::ranges::min_element(holds, {}, &ToolHold::gap) - holds.begin());
  for (int i = slot.unknown; i < slot.unknown + slot.unknowns; ++i) {
    const int hold = set_.unknowns()[Index(i)].hold;
    const bool guess = holds[Index(hold)].gap < kGuess * tool.depth * length_unit_;
    const bool touches = tool.touching == Touching::kAll || hold == nearest ||
                         (tool.touching == Touching::kSome && guess);
    touches_[Index(i)] = touches ? 1 : 0;
  }
}

// Finds the places that penetrate their tool or, if they are to be released, pull; false: there are
// none.
bool ComplianceSolver::FindInfeasible(bool releases) {
  infeasible_.clear();
  for (std::size_t i = 0; i < tools_.size(); ++i) {
    const ContactSlot& slot = set_.slots()[i];
    if (!slot.is_tool() || tools_[i].touching != Touching::kSome) continue;
    const Vector3d& n = slot.footprint.normal_O;
    double largest = 0;
    double pulling = 0, pushing = 0;
    for (const auto& u : UnknownsOf(slot)) {
      const double along = n.dot(ForceOf(u));
      largest = std::max(largest, std::abs(along));
      (along > 0 ? pulling : pushing) += std::abs(along);
    }
    is_settled_ = is_settled_ && (releases || pulling <= kSmallPull * pushing);
    for (std::size_t k = 0; k < Index(slot.unknowns); ++k) {
      const std::size_t number = Index(slot.unknown) + k;
      const ForceUnknown& u = set_.unknowns()[number];
      if (touches_[number] != 0) {
        const bool pulls = releases && n.dot(ForceOf(u)) > kSlack * largest;
        if (pulls) infeasible_.push_back(number);
        continue;
      }
      const double least = tools_[i].depth - slot.footprint.holds[Index(u.hold)].gap / length_unit_;
      const double sunk = -DisplacementAlong(n, u);
      if (least - sunk > kSlack * tools_[i].depth) infeasible_.push_back(number);
    }
  }
  return !infeasible_.empty();
}

void ComplianceSolver::SwitchInfeasible() {
  const auto change = [this](std::size_t i) { touches_[i] = touches_[i] != 0 ? 0 : 1; };
  if (infeasible_.size() < fewest_infeasible_) {
    fewest_infeasible_ = infeasible_.size();
    blocks_left_ = kBlocks;
  } else if (blocks_left_ == 0) {
    return change(infeasible_.back());
  } else {
    --blocks_left_;
  }
  std::ranges::for_each(infeasible_, change);
}

// Displacement of a place that does not touch, along n [length units].
double ComplianceSolver::DisplacementAlong(const Vector3d& n, const ForceUnknown& at) const {
  double along = 0;
  for (int k = 0; k < at.count; ++k) {
    const double* row = whole_.data() + (at.row + k) * whole_stride_;
    double moved = std::inner_product(forces_.begin(), forces_.end(), row, 0.0);
    for (std::size_t i = 0; i < set_.slots().size(); ++i) {
      const int load = set_.slots()[i].load;
      for (int c = 0; c < compliance_.components() && load >= 0; ++c) {
        moved += Value(i)[c] * loads_.unknowns_by(load, c)[Index(at.row + k)];
      }
    }
    along += n.dot(at.basis.col(k)) * moved;
  }
  return along;
}

double ComplianceSolver::FollowedPart(std::size_t contact, const ForceUnknown& at) const {
  if (at.hold < 0 || tools_[contact].touching != Touching::kSome) return 1;
  const double gap = set_.slots()[contact].footprint.holds[Index(at.hold)].gap;
  return 1 - gap / (length_unit_ * tools_[contact].depth);
}

// Adds what a contact's value prescribes to right_.
void ComplianceSolver::AddPrescribed(std::size_t contact) {
  const ContactSlot& slot = set_.slots()[contact];
  const Vector3d value = Value(contact);
  for (int c = 0; c < compliance_.components() && slot.load >= 0; ++c) {
    const auto by = loads_.unknowns_by(slot.load, c);
    for (std::size_t r = 0; r < by.size(); ++r) {
      if (position_[r] >= 0) right_[Index(position_[r]) * kLane8] -= value[c] * by[r];
    }
  }
  for (const auto& u : UnknownsOf(slot)) {
    const int row = position_[Index(u.row)];
    const double part = FollowedPart(contact, u);
    for (int k = 0; k < u.count && row >= 0; ++k) {
      right_[Index(row + k) * kLane8] += part * u.basis.col(k).dot(value);
    }
  }
}

// Fills one column per unit value that a contact prescribes.
void ComplianceSolver::FillUnitColumns(const ContactSlot& slot, double* first) const {
  for (int c = 0; c < compliance_.components() && slot.load >= 0; ++c) {
    const auto by = loads_.unknowns_by(slot.load, c);
    for (std::size_t r = 0; r < by.size(); ++r) {
      if (position_[r] >= 0) first[position_[r] * column_stride_ + c] = -by[r];
    }
  }
  for (const auto& u : UnknownsOf(slot)) {
    if (position_[Index(u.row)] < 0) continue;
    for (int k = 0; k < u.count; ++k) {
      double* row = first + position_[Index(u.row + k)] * column_stride_;
      for (int c = 0; c < compliance_.components(); ++c) row[c] = u.basis(c, k);
    }
  }
}

// Computes the forces for unit values of every contact, and the stiffness of each.
void ComplianceSolver::SolveColumns() {
  const auto slots = set_.slots();
  const int components = compliance_.components();
  column_stride_ = PaddedTo8(components * static_cast<int>(slots.size()));
  columns_.assign(Index(factor_.order()) * Index(column_stride_), 0.0);
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
  for (const auto& u : UnknownsOf(slot)) {
    if (position_[Index(u.row)] < 0) continue;
    for (int k = 0; k < u.count; ++k) {
      const double* row = first + position_[Index(u.row + k)] * column_stride_;
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
        if (position_[k] < 0) continue;
        own(r, c) += at[k] * first[position_[k] * column_stride_ + c];
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
  forces_.assign(Index(rows), 0.0);
  if (columns_known_ && !TouchesGaps()) {
    const auto count = static_cast<Eigen::Index>(values_.size());
    const Eigen::Map<const Eigen::VectorXd> values(values_.data(), count);
    for (int r = 0; r < rows; ++r) {
      if (position_[Index(r)] < 0) continue;
      const double* row = columns_.data() + position_[Index(r)] * column_stride_;
      forces_[Index(r)] = values.dot(Eigen::Map<const Eigen::VectorXd>(row, count));
    }
    return;
  }
  right_.assign(Index(factor_.order()) * kLane8, 0.0);
  for (std::size_t i = 0; i < set_.slots().size(); ++i) AddPrescribed(i);
  factor_.Solve({right_.data(), kLane8});
  for (std::size_t r = 0; r < forces_.size(); ++r) {
    if (position_[r] >= 0) forces_[r] = right_[Index(position_[r]) * kLane8];
  }
}

// Returns whether a place that touches follows its tool only in part.
bool ComplianceSolver::TouchesGaps() const {
  for (std::size_t i = 0; i < tools_.size(); ++i) {
    if (tools_[i].touching != Touching::kSome) continue;
    for (const auto& u : UnknownsOf(set_.slots()[i])) {
      if (position_[Index(u.row)] >= 0 && FollowedPart(i, u) != 1) return true;
    }
  }
  return false;
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
    for (const auto& u : UnknownsOf(slot)) force += ForceOf(u);
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
  const double error = slot.is_tool() ? TouchError(slot) : slot.footprint.patch_error;
  const bool coarse = IsContactCoarse(error, params_.young_modulus * slot.contact.width,
                                      response.force_O, response.displacement_O);
  const bool is_valid = deflection <= params_.range && !coarse && !slot.on_support && is_settled_;
  response.validity = is_valid ? Validity::kValid : Validity::kExtrapolated;
  response.takes_width = slot.is_tool() || slot.footprint.narrower != 0;
  if (slot.is_tool()) {
    response.touching = TouchingOf(slot);
    response.spring_share = SpringShare(slot, response);
    response.force_error = EdgeError(slot) * response.force_O.norm();
  }
  if (coarse) response.flag_reason = slot.touches_few() ? kFewTouched : kCoarsePatch;
  if (!is_settled_) response.flag_reason = kNotSettled;
  if (slot.on_support) response.flag_reason = kOnSupport;
  SetMomentOf(slot, &response);
  return response;
}

int ComplianceSolver::TouchingOf(const ContactSlot& slot) const {
  const auto first = touches_.begin() + slot.unknown;
  return static_cast<int>(std::count(first, first + slot.unknowns, 1));
}

// Relative error of a tool's force because a plane contact ends at a whole place [-].
double ComplianceSolver::EdgeError(const ContactSlot& slot) const {
  const int touching = TouchingOf(slot);
  const bool is_inside = slot.contact.radius > 0 || touching < slot.unknowns;
  if (compliance_.components() == 3 || touching == 0 || !is_inside) return 0;
  return kOfEdge / (touching * touching);
}

// Relative error of the compliance of a tool by the number of places that it touches [-].
double ComplianceSolver::TouchError(const ContactSlot& slot) const {
  const ToolState& tool = tools_[static_cast<std::size_t>(&slot - set_.slots().data())];
  if (tool.touching == Touching::kNearest && tool.depth <= 0) return 0;
  double touched = 0;  // places, by their shares
  for (const auto& u : UnknownsOf(slot)) {
    if (position_[Index(u.row)] >= 0) touched += slot.footprint.holds[Index(u.hold)].share;
  }
  const double error = FewTouchedError(touched, slot.footprint.fewest, slot.contact.radius > 0);
  // In the plane a contact's share of the compliance is not known.
  const bool is_plane = compliance_.components() == 2;
  return is_plane && error > 0 ? std::numeric_limits<double>::infinity()
                               : std::max(error, slot.footprint.patch_error);
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
  if (slot.is_tool()) return SetMomentOfTool(slot, response);
  const auto force_at = [&](std::size_t i) -> Vector3d {
    return force_unit_ * ForceOf(set_.unknowns()[Index(slot.unknown) + i]);
  };
  SetMoment(arms, slot.contact.width, force_at, response, params_.moment);
}

void ComplianceSolver::SetMomentOfTool(const ContactSlot& slot, ContactResponse* response) const {
  const bool is_round = slot.contact.radius > 0;
  const auto touching = Index(response->touching);
  if (touching < (is_round ? kFewestUnderRound : params_.moment.fewest)) return;
  Vector3d moment = Vector3d::Zero();
  double reach = 0;
  for (const auto& u : UnknownsOf(slot)) {
    if (position_[Index(u.row)] < 0) continue;
    const Vector3d& arm = slot.footprint.arms[Index(u.hold)];
    moment += arm.cross(force_unit_ * ForceOf(u));
    reach = std::max(reach, arm.norm());
  }
  response->moment_O = moment;
  const double error =
      is_round ? kSpreadUnderRound * 2 * reach : params_.moment.spread * slot.contact.width;
  response->moment_sigma = error / static_cast<double>(touching) * response->force_O.norm();
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
