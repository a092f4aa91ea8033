#include "slave/mechanics/fem/zone/fem_zone_model.h"

#include <algorithm>
#include <cmath>
#include <exception>
#include <limits>
#include <stdexcept>

#include "shared/mesh/disc_patch.h"
#include "shared/text/text.h"
#include "slave/mesh/index.h"
#include "slave/mesh/mesh_census.h"

namespace palpate {
namespace {

using Eigen::Vector3d;
using Eigen::VectorXd;

constexpr double kLocks = 0.49;  // Poisson ratio
// What steps will still change, by the force: from rest, and of a contact that has moved a little.
constexpr double kConverged = 1e-4, kFollowed = 2e-3;
// Longest edge by smallest height of an element from which on the kept columns, of 16 to 24 bits,
// have too few digits [-]. [measured: extremes_test has 6e-5 of the displacement at 100, 2 % at
// 1000]
constexpr double kMostStretched = 50;
constexpr double kNoForce =
    1e-12;  // of a tool that has left, by E and the larger side squared [by definition]
constexpr int kMostSteps = 60;
// First steps, which take what has changed most: of a contact that has moved a little, from rest.
constexpr int kSmallSteps = 4, kFirstSteps = 2;
constexpr double kForSteps = 0.6;   // of the deadline; the rest is for the errors [-]
constexpr double kIncrement = 0.1;  // of a tool between two accepted states [edges]
// Each acts on each other one, with 2.5 MB per pair. [by definition]
constexpr std::size_t kMostContacts = 16;
constexpr int kFewestPoints = 3;   // of a round tool on its mesh
constexpr int kMostPortions = 64;  // of what is prescribed, from rest
constexpr double kSmall = 1e-9;    // displacement at which bending is judged, of the larger side
// Contacts so near to each other, and so nearly of one size, bend the body alike: elements near
// them are left out [radii of a zone]. [tuned: ANearbyContactBendsTheBodyAlike]
constexpr double kAlike = 0.25;
constexpr std::size_t kKept = 256;  // of contacts, for how they bend the body

constexpr std::string_view kStretched =
    "an element is stretched: expected a longest edge of at most 50 heights";
// [measured: bench_zone, and a round tool without friction 18 % off at an estimate of zero]
constexpr std::string_view kSeveralContacts =
    "several contacts at once: the estimated error of fem-zone does not hold";
constexpr std::string_view kNoFriction =
    "a tool without friction: the estimated error of fem-zone does not hold";
constexpr std::string_view kTooNonlinear =
    "the body outside the contact's zone is not linear enough for the tolerance";

ZoneTouches::Params TouchParams(const FemZoneModel::Options& options) {
  const bool bonded = options.contact == ContactLaw::kBonded;
  const bool slides = options.contact == ContactLaw::kFriction;
  return {.friction =
              bonded ? std::numeric_limits<double>::infinity() : (slides ? options.friction : 0),
          .tool = options.tool,
          .least_radius = options.least_radius};
}

bool IsStretched(const SolidMesh& mesh) {
  return std::ranges::any_of(mesh.tets, [&](const std::array<int, 4>& tet) {
    double longest = 0;
    for (const int a : tet) {
      for (const int b : tet) {
        longest = std::max(longest, (mesh.nodes[Index(a)] - mesh.nodes[Index(b)]).norm());
      }
    }
    const double height = 1 / GeometryOf(mesh.nodes, tet).grad.colwise().norm().maxCoeff();
    return !(longest <= kMostStretched * height);
  });
}

double Positive(const char* key, double value) {
  if (!(value > 0 && std::isfinite(value))) RefuseValue(key, value, "a finite number > 0");
  return value;
}

}  // namespace

FemZoneModel::FemZoneModel(const SolidMesh& mesh, const HeldNodes& held, double young_modulus,
                           double poisson_ratio, const Options& options, Progress* progress)
    : young_modulus_(Positive("young_modulus", young_modulus)),
      poisson_ratio_(poisson_ratio),
      options_(options),
      mesh_((Positive("tolerance", options.tolerance),
             ReportProgress(progress, "factorising stiffness", 0), mesh)),
      held_(held),
      green_(mesh_, held_, poisson_ratio, options.memory_limit, options.cache),
      unit_(green_.length_unit()),
      elements_(MakeTetMesh(mesh_, 4, unit_)),
      contacts_(mesh_, 4, held_, unit_, young_modulus_ * unit_ * unit_),
      strain_(elements_, held_, poisson_ratio),
      touches_at_(mesh_, held_, TouchParams(options)),
      is_stretched_(IsStretched(mesh_)) {
  ReportProgress(progress, "factorising stiffness", 1);
  field_mesh_ = {.vertices = mesh_.nodes, .tets = mesh_.tets};
  keeps_displacements_ = true;
  info_.kind = "fem-zone";
  info_.dof = 3 * mesh_.nodes.size();
  info_.elements = static_cast<int>(mesh_.tets.size());
  info_.memory_bytes = green_.memory_bytes();
  info_.remark = poisson_ratio >= kLocks
                     ? "linear tetrahedra lock near nu = 0.5: the model is much too stiff"
                     : "tet4, nonlinear around contacts only; the first touch of a region is slow";
  NotePrecompute();
}

void FemZoneModel::Reset() {
  if (set_) set_->Reset();
  follows_ = false;
  for (Vector3d& moved : moved_) moved.setZero();
  inverted_ = false;
}

bool FemZoneModel::PrefetchSurface(double width, Progress* progress) {
  const ZoneTouches::Cover cover = touches_at_.CoverOf(width);
  const double reach = ZoneSet::ReachOf(cover.radius, cover.extent) / unit_;
  const bool all = green_.Prepare(cover.nodes, reach, progress);
  info_.memory_bytes = green_.memory_bytes();
  if (!all) {
    info_.remark =
        "tet4, nonlinear around contacts only; without memory for the whole surface, the "
        "first touch of a region is slow";
  }
  NotePrecompute();
  return all;
}

CacheFilling FemZoneModel::FillCache(double width, const CacheShare& share, Progress* progress) {
  const ZoneTouches::Cover cover = touches_at_.CoverOf(width);
  return green_.FillCache(cover.nodes, ZoneSet::ReachOf(cover.radius, cover.extent) / unit_, share,
                          progress);
}

void FemZoneModel::Prefetch(std::span<const Contact> contacts) {
  try {
    if (!PrepareSet(contacts)) contacts_.Forget();
  } catch (const std::exception&) {
    contacts_.Forget();  // Respond tells
  }
}

bool FemZoneModel::PrepareSet(std::span<const Contact> contacts) {
  if (contacts.size() > kMostContacts) return Fail("more contacts than the 16 that fem-zone takes");
  if (!contacts_.Prepare(contacts)) return Fail(contacts_.failure());
  if (contacts_.change() == VolumeContacts::Change::kNone && set_) return true;
  set_.reset();
  softness_.clear();
  inverted_ = follows_ = false;
  std::vector<ZoneSet::Touch> touches(contacts.size());
  for (std::size_t i = 0; i < contacts.size(); ++i) {
    const std::string_view why = touches_at_.Make(contacts[i], contacts_.places()[i], &touches[i]);
    if (!why.empty()) return Fail(why);
  }
  prescribed_.clear();
  for (const auto& touch : touches) {
    prescribed_.push_back(VectorXd::Zero(touch.contact.tool ? 3 : touch.contact.unknowns()));
  }
  moved_.assign(touches.size(), Vector3d::Zero());
  touches_ = touches;
  if (touches.empty()) return true;
  set_.emplace(green_, mesh_, poisson_ratio_, touches);
  info_.memory_bytes = green_.memory_bytes();
  LearnBending();
  return true;
}

const FemZoneModel::Bending* FemZoneModel::BendingAt(const ZoneSet::Touch& touch) const {
  const auto found = std::ranges::find_if(learned_, [&](const Bending& known) {
    return std::abs(known.radius - touch.radius) < kAlike * touch.radius &&
           (known.p_O - touch.centre_O).norm() < kAlike * touch.radius;
  });
  return found == learned_.end() ? nullptr : &*found;
}

// Where a part bends, the mean over the axes is taken by the work that the force does along each.
void FemZoneModel::LearnBending() {
  softness_.assign(Index(set_->size()), Vector3d::Zero());
  if (!strain_.body_bends()) return;
  bool all_known = true;
  for (std::size_t i = 0; i < touches_.size(); ++i) {
    const Bending* known = BendingAt(touches_[i]);
    all_known = all_known && known != nullptr;
    if (known != nullptr) softness_[i] = known->softness;
  }
  if (all_known) return;
  const Eigen::MatrixXd duals = set_->DualDisplacements();
  std::vector<Vector3d> u(mesh_.nodes.size());
  std::vector<int> touched;
  for (const ContactPlace& place : contacts_.places()) {
    for (const auto& [node, weight] : place.nodes) touched.push_back(node);
  }
  for (int i = 0; i < set_->size(); ++i) {
    Vector3d softness = Vector3d::Zero();
    for (int c = 0; c < 3; ++c) {
      const VectorXd dual = duals.col(3 * i + c);
      const double size = dual.cwiseAbs().maxCoeff();
      for (std::size_t n = 0; size > 0 && n < u.size(); ++n) {
        u[n] = kSmall / size * dual.segment<3>(3 * static_cast<int>(n));
      }
      if (size > 0) softness[c] = strain_.Softness(u, touched);
    }
    softness_[Index(i)] = softness;
    const ZoneSet::Touch& touch = touches_[Index(i)];
    if (learned_.size() >= kKept) learned_.clear();
    if (BendingAt(touch) == nullptr) learned_.push_back({touch.centre_O, softness, touch.radius});
  }
}

void FemZoneModel::Prescribe(std::span<const Contact> contacts, double part) {
  const double force_unit = young_modulus_ * unit_ * unit_;
  for (std::size_t i = 0; i < contacts.size(); ++i) {
    const bool loaded = contacts[i].kind == Contact::Kind::kForce;
    const Vector3d value = contacts[i].prescribed_O / (loaded ? force_unit : unit_);
    for (int k = 0; k < prescribed_[i].size(); ++k) prescribed_[i][k] = part * value[k % 3];
  }
}

// For every contact, by its own force and a little of the largest.
bool FemZoneModel::HasConverged(double within, bool* finite) const {
  double largest = 0;
  *finite = true;
  const auto size_of = [&](const ZonePart& part) {
    return part.contact().loaded ? part.MeanDisplacement().norm() : part.Force().norm();
  };
  for (int i = 0; i < set_->size(); ++i) {
    *finite = *finite && set_->part(i).IsFinite();
    if (!set_->part(i).contact().loaded) largest = std::max(largest, size_of(set_->part(i)));
  }
  for (int i = 0; i < set_->size(); ++i) {
    const ZonePart& part = set_->part(i);
    const double scale = size_of(part) + (part.contact().loaded ? 0 : 0.01 * largest + kNoForce);
    if (!(set_->Remaining(i) <= within * scale)) return false;
  }
  return true;
}

bool FemZoneModel::Converge() {
  set_->Begin(prescribed_);
  for (int step = 0; step < kMostSteps; ++step) {
    set_->Step(step >= (follows_ ? kSmallSteps : kFirstSteps));
    bool finite = true;
    const bool follows = follows_ && step < kSmallSteps;
    const bool converged = HasConverged(follows ? kFollowed : kConverged, &finite);
    if (!finite) return false;
    if (converged || IsLate()) return true;
  }
  return false;
}

// What the steps still lack is part of the bound.
bool FemZoneModel::IsLate() const {
  return options_.deadline > 0 && SecondsSince(begun_) > kForSteps * options_.deadline;
}

// From the last state, else from rest in parts.
bool FemZoneModel::SolveState(std::span<const Contact> contacts) {
  if (inverted_) Reset();  // such states may be traps
  Prescribe(contacts, 1);
  if (std::ranges::any_of(touches_,
                          [](const auto& touch) { return touch.contact.tool.has_value(); })) {
    return MoveTools(contacts) || Fail("no equilibrium was found");
  }
  if (Converge()) return true;
  for (int parts = 4; parts <= kMostPortions; parts *= 4) {
    set_->Reset();
    bool solved = true;
    for (int k = 1; solved && k <= parts; ++k) {
      Prescribe(contacts, static_cast<double>(k) / parts);
      solved = Converge();
    }
    if (solved) return true;
  }
  return Fail("no equilibrium was found");
}

void FemZoneModel::FollowTools(std::span<const Contact> contacts) {
  for (int i = 0; i < set_->size(); ++i) {
    const ToolContact* tool = ToolOf(i);
    if (tool == nullptr) continue;
    ZoneSet::Touch& touch = touches_[Index(i)];
    auto next = touches_at_.Follow(contacts[Index(i)], *tool, touch);
    if (!next) continue;
    set_->Replace(i, *next);
    touch = std::move(*next);
  }
}

// In increments, each accepted, so that friction follows the way. After the deadline the rest of
// the way is one increment.
bool FemZoneModel::MoveTools(std::span<const Contact> contacts) {
  double parts = 1;
  for (std::size_t i = 0; i < touches_.size(); ++i) {
    const double edge = touches_at_.edge(touches_[i].nodes.front());
    const double way = (contacts[i].prescribed_O - unit_ * moved_[i]).norm();
    if (touches_[i].contact.tool) parts = std::max(parts, std::ceil(way / (kIncrement * edge)));
  }
  if (!(parts < 1e4)) return false;
  follows_ = follows_ && parts == 1;
  FollowTools(contacts);  // here, so that the error of an answer is that of the zones it comes from
  const std::vector<Vector3d> from = moved_;
  const auto place = [&](double part) {
    for (std::size_t i = 0; i < touches_.size(); ++i) {
      if (!touches_[i].contact.tool) continue;
      moved_[i] = from[i] + part * (contacts[i].prescribed_O / unit_ - from[i]);
      prescribed_[i] = moved_[i];
    }
  };
  for (int k = 1; k < static_cast<int>(parts) && !IsLate(); ++k) {
    place(k / parts);
    set_->Begin(prescribed_);
    for (int step = 0; step < kFirstSteps; ++step) set_->Step(true);
    set_->Accept();
    FollowTools(contacts);
  }
  place(1);
  set_->RefreshDuals();
  bool finite = true;  // what slow steps still lack is part of the bound
  if (!Converge() && !(HasConverged(options_.tolerance, &finite) && finite)) return false;
  set_->Accept();
  set_->RefreshDuals();
  return true;
}

void FemZoneModel::ComputeResponses(std::span<const Contact> contacts,
                                    std::span<ContactResponse> responses) noexcept {
  failure_ = {};
  begun_ = std::chrono::steady_clock::now();
  bool answered = false;
  try {
    answered = responses.size() == contacts.size() && TryRespond(contacts, responses);
  } catch (const std::exception&) {
    failure_ = "out of memory, or a zone that cannot be condensed";
  }
  if (answered) return;
  if (failure_.empty()) failure_ = "the number of responses and contacts must be equal";
  std::ranges::fill(responses, ContactResponse{});
  contacts_.Forget();
  set_.reset();
}

bool FemZoneModel::TryRespond(std::span<const Contact> contacts,
                              std::span<ContactResponse> responses) {
  if (!PrepareSet(contacts)) return false;
  if (!set_) return true;
  if (!SolveState(contacts)) return false;
  follows_ = true;
  Fill(contacts, responses);
  return true;
}

std::string_view FemZoneModel::DoubtOf(std::size_t contact, const ContactResponse& response) const {
  if (inverted_) return "elements are inside out";
  if (is_stretched_) return kStretched;
  if (poisson_ratio_ < 0) return "the error is not estimated at a negative Poisson ratio";
  if (poisson_ratio_ >= kLocks) return "linear tetrahedra lock at this Poisson ratio";
  const ToolContact* tool = ToolOf(static_cast<int>(contact));
  if (tool != nullptr) {
    const int touching = tool->touching();
    if (touching == 0) return {};
    if (touching < kFewestPoints) return kCoarsePatch;
  } else if (contacts_.IsCoarse(contact, response)) {
    return kCoarsePatch;
  }
  const bool loaded = set_->part(static_cast<int>(contact)).contact().loaded;
  const bool slips = options_.contact == ContactLaw::kFrictionless ||
                     (options_.contact == ContactLaw::kFriction && !(options_.friction > 0));
  if (touches_.size() > 1) return kSeveralContacts;
  if (slips && !loaded) return kNoFriction;
  const double size = loaded ? response.displacement_O.norm() : response.force_O.norm();
  const double bound = loaded ? response.displacement_error : response.force_error;
  if (!(bound <= options_.tolerance * size)) return kTooNonlinear;
  const Eigen::Array3d work = response.force_O.array() * response.displacement_O.array();
  const double whole = work.abs().sum();
  if (whole > 0 && (work.abs() * softness_[contact].array()).sum() > kMostSoftness * whole) {
    return kStiffInBending;
  }
  return {};
}

void FemZoneModel::Fill(std::span<const Contact> contacts, std::span<ContactResponse> responses) {
  const double force_unit = young_modulus_ * unit_ * unit_;
  inverted_ = set_->SmallestJacobian() <= 0;
  set_->EstimateErrors();
  for (std::size_t i = 0; i < contacts.size(); ++i) {
    const int number = static_cast<int>(i);
    const ZonePart& part = set_->part(number);
    const double bound = set_->bound(number) + set_->Remaining(number);
    ContactResponse response;
    if (part.contact().loaded) {
      response.force_O = contacts[i].prescribed_O;
      response.displacement_O = unit_ * part.MeanDisplacement();
      response.displacement_error = unit_ * bound;
    } else {
      response.displacement_O = contacts[i].prescribed_O;
      response.force_O = force_unit * part.Force();
      response.force_error = force_unit * bound;
    }
    const ContactPlace& place = contacts_.places()[i];
    const auto force_at = [&](std::size_t k) -> Vector3d {
      if (place.is_point || part.contact().loaded) return place.nodes[k].weight * response.force_O;
      return force_unit * part.contact_forces().forces().segment<3>(3 * static_cast<int>(k));
    };
    if (!touches_[i].contact.tool) SetMoment(place.arms, contacts[i].width, force_at, &response);
    response.doubt = DoubtOf(i, response);
    response.validity = response.doubt.empty() ? Validity::kValid : Validity::kExtrapolated;
    responses[i] = response;
  }
}

void FemZoneModel::ComputeDisplacements(std::vector<Vector3d>* u_O) {
  u_O->assign(mesh_.nodes.size(), Vector3d::Zero());
  if (!set_) return;
  const VectorXd u = set_->Displacements().col(0);
  for (std::size_t n = 0; n < u_O->size(); ++n) {
    (*u_O)[n] = unit_ * u.segment<3>(3 * static_cast<int>(n));
  }
}

}  // namespace palpate
