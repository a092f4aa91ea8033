#include "slave/mechanics/fem/static_equilibrium.h"

#include <algorithm>
#include <cmath>
#include <utility>

#include "slave/mesh/index.h"

namespace palpate::fem {
namespace {

using After = ToolContact::After;

constexpr int kMaxSteps = 1000;            // of Newton's method with the warped tangent
constexpr int kMaxHyperelasticSteps = 60;  // the same with the exact tangent
constexpr double kMinPart = 1.0 / 64;      // smallest part of a load that is applied in one step
// Largest cost of a factor that is made in every step with the exact tangent [operations].
constexpr double kFactorOnce = 3e8;
// Additional stiffness that makes an exact tangent definite, in units of E.
constexpr double kMinShift = 1.0 / 64, kMaxShift = 4;
constexpr int kMaxHalvings = 24;     // halvings of one such step
constexpr double kInner = 1e-2;      // tolerance of a linear system relative to its right-hand side
constexpr double kErrorShare = 0.1;  // accuracy of the correction relative to the residual
// Error that the correction leaves, relative to the correction and to the share of the residual
// that is left [-]. With 1 the median of estimated by true error is 1 to 1.6, and of single queries
// a tenth were more than three times their estimate. [measured: bench_organ]
constexpr double kLeftShare = 3;
// Tolerance of a contact's forces and gaps after the correction, relative to that before [-], and
// how often contacts that it changes are searched again.
constexpr double kDecisionShare = 0.02;
constexpr int kCorrections = 5;
// Residual after a correction from which on another one follows, relative to that aimed at with
// tools [-].
constexpr double kLeaves = 0.2;
// Largest residual with friction [-], which depends on the path: an error of one query stays in the
// places where nodes stick. At 5e-2, 1e-2 and 1e-3 the p99 error of the force was 1.7, 0.8 and
// 0.03 %. [measured: eight tools on bench_organ's slab and bar, mu 0.3, 0.3 mm per query]
constexpr double kWithFriction = 1e-3;
// Smallest one: contacts are decided with this tolerance (tool_contact.cpp).
constexpr double kLeastWithFriction = 1e-9;
// The p99 error of the force, relative to the residual: at most this on five of bench_organ's six
// bodies, 1.2 on the cube. [measured: as above]
constexpr double kPathShare = 0.3;
constexpr double kLinearShare = 0.5;  // of the residual aimed at, left by a linear system
constexpr double kForSteps = 0.6;     // share of the deadline for steps; the rest is for the error
// Smallest share of a motion's square that is independent of newer motions, else it adds no
// direction [-]. With 1e-2 slow circles need 0.95 steps per query, with 2e-3 0.17. [measured:
// bench_organ's bodies, eight tools, 0.3 mm per query]
constexpr double kIndependentMotion = 2e-3;
constexpr double kMaxAhead = 3;  // largest factor of an earlier motion in the prediction [-]
// Residual that indicates the end of a contact, relative to the largest one of an equilibrium [-].
constexpr double kLetGo = 2;
constexpr double kSufficient = 1e-4;
// Target of the residual relative to the requested one, because with a factor additional accuracy
// is cheap.
constexpr double kAimDirect = 1e-4, kAimIterative = 0.3, kAimTouching = 0.6;
// Residual that a linear system leaves of the motion of tools at most [-]. A tool that moves little
// beside one that is deep moves the body, too.
constexpr double kMotionShare = 0.2;
// Change of a share of area that needs another search [-]: the force changes by half of it at most.
constexpr double kShareChange = 2e-3;
constexpr int kShareSearches = 8;
// Growth of the residual by new contacts, relative to the rest of it, from which on the next step
// needs no tangent of its own [-].
constexpr double kByContact = 2;
// Reduction of the residual for which the tangent of the previous step is sufficient. It reduces
// the residual by a factor of 3 to 10 if that step was predicted [-]. [measured: bench_organ]
constexpr double kBySameTangent = 3;
// Friction follows the normal reactions within a step to this share of its change [-], in as many
// solutions at most.
constexpr double kFollowed = 1e-2;
constexpr int kFollowSolutions = 8;
constexpr double kForceRounding = 4e-16;  // of the diagonal's forces
constexpr double kStalled = 0.5;
constexpr double kGapRounding = 1e-13;  // of all gaps [larger sides]

// Rounding error of forces that cancel in exact arithmetic.
double RoundingFloor(const BlockMatrix& A, const NodeVector& u) {
  double square = 0;
  for (int i = 0; i < A.pattern().rows(); ++i) {
    const double* block = A.block(A.pattern().diagonal[Index(i)]);
    for (std::size_t c = 0; c < 3; ++c) {
      const double force = block[4 * c] * At(u, i).v[c];
      square += force * force;
    }
  }
  return kForceRounding * std::sqrt(square);
}

}  // namespace

StaticEquilibrium::StaticEquilibrium(FemBody& body, const Params& params)
    : body_(body),
      params_(params),
      hyperelastic_(body.law() == TetElements::Law::kNeoHookean),
      progress_(params.progress, params.linear),
      tangent_(body.pattern()),
      solver_(body, {.late_factor = !hyperelastic_,
                     .max_flops = hyperelastic_ ? kFactorOnce : LinearSolver::kAnyFlops,
                     .follows = true,
                     .progress = &progress_}) {
  for (auto* x : {&u_, &last_u_, &good_u_, &f_ext_, &last_f_, &f_int_, &r_, &x_, &lift_, &trial_,
                  &reaction_, &f_base_, &kept_u_, &gap_force_, &last_reaction_, &s_, &left_, &p_}) {
    x->resize(Index(body.size()));
  }
  for (Motion& motion : motions_) {
    motion.body.resize(Index(body.size()));
    motion.contacts.resize(Index(body.size()));
  }
  for (FrictionStep& step : friction_steps_) {
    step.x.resize(Index(body.size()));
    step.change.resize(Index(body.size()));
  }
}

double StaticEquilibrium::TargetResidual() const {
  if (WithFriction()) return kAimTouching * Requested();
  if (solver_.direct()) return kAimDirect * params_.residual;
  return (tools_ != nullptr ? kAimTouching : kAimIterative) * params_.residual;
}

bool StaticEquilibrium::WithFriction() const {
  return tools_ != nullptr && tools_->have_friction();
}

double StaticEquilibrium::PathError() const {
  return kPathShare * std::min(params_.residual, kWithFriction);
}

double StaticEquilibrium::Requested() const {
  return WithFriction() ? std::clamp(params_.residual, kLeastWithFriction, kWithFriction)
                        : params_.residual;
}

void StaticEquilibrium::Reset() noexcept {
  SetZero(u_);
  SetZero(last_f_);
  SetZero(reaction_);
  summary_ = {};
  shift_ = 0;
  motion_count_ = 0;
  reference_ = released_ = 0;
  is_current_ = has_tangent_ = is_near_ = false;
  body_.ForgetRotations();
  solver_.Reset();
  if (hyperelastic_) Update(With::kTangent);
}

void StaticEquilibrium::Begin() noexcept {
  newton_steps_ = iterations_ = 0;
  ended_early_ = false;
  progress_.Begin();
  before_ = Norm(reaction_);
}

bool StaticEquilibrium::Increment(const NodeVector& f_ext, const Constraints& constraints,
                                  ToolContacts& tools, bool is_last) noexcept {
  last_u_ = u_;
  tools_ = &tools;
  corrects_ = is_last;
  f_base_ = f_ext_ = f_ext;
  if (!is_current_) Update(With::kTangent);
  tools.Load(f_base_, &f_ext_);
  tools.HoldTouched();
  const double size = FreeResidual(constraints);
  const bool lets_go = hyperelastic_ && has_new_constraints_ &&
                       size > kLetGo * params_.residual * std::max(reference_, before_);
  if (lets_go) motion_count_ = 0;
  const bool changes = tools.UpdateTouching(u_, reaction_, TargetResidual(), After::kPrediction);
  has_new_constraints_ = has_new_constraints_ || changes;
  solver_.Follow();
  Predict(constraints);
  tools.UpdateTouching(u_, reaction_, TargetResidual(), After::kPrediction);
  tools.Load(f_base_, &f_ext_);
  bool found = Iterate(constraints, 1);
  for (int k = 0; found && !ended_early_ && k < kShareSearches; ++k) {
    if (tools.UpdateShares(u_) < std::min(kShareChange, Requested())) break;
    tools.UpdateTouching(u_, reaction_, TargetResidual(), After::kStep);
    tools.Load(f_base_, &f_ext_);
    solver_.Follow();
    found = Iterate(constraints, 1);
  }
  keeps_tangent_ = false;
  if (found) {
    last_f_ = f_ext;
    if (!lets_go) LearnMotion(constraints);
    // A lifted tool has no history: the motions of its last touch would move the places where nodes
    // stick at the next one.
    if (!tools.touches()) motion_count_ = 0;
    tools_ = nullptr;
    return true;
  }
  tools_ = nullptr;
  Retreat(last_u_);
  motion_count_ = 0;
  return false;
}

void StaticEquilibrium::End(const Constraints& constraints, ToolContacts& tools) noexcept {
  tools_ = &tools;
  settles_ = true;
  corrects_ = false;
  for (int k = 1; k <= kCorrections; ++k) {
    const Correction correction =
        Correct(constraints, k < kCorrections ? Contacts::kFollow : Contacts::kStay);
    solver_.Follow();
    if (correction == Correction::kRefused && k > 1) break;
    if (relative_residual_ <= kLeaves * kAimTouching * Requested()) break;
    const bool suffices = ended_early_ || relative_residual_ <= Requested();
    if (correction != Correction::kContactsChange && suffices) continue;
    last_u_ = u_;
    if (Iterate(constraints, 1)) continue;
    tools.Retreat();
    Retreat(last_u_);
    LoadTools();
    break;
  }
  settles_ = false;
  tools_ = nullptr;
}

void StaticEquilibrium::TakeBack() noexcept {
  motion_count_ = 0;
  Retreat(kept_u_);
}

bool StaticEquilibrium::Solve(const NodeVector& f_ext, const Constraints& constraints) noexcept {
  last_u_ = u_;
  Begin();
  const bool lets_go = LetsGo(constraints);
  if (lets_go) motion_count_ = 0;
  Predict(constraints);
  if (SolveInParts(f_ext, constraints)) {
    if (!lets_go) LearnMotion(constraints);
    Correct(constraints, Contacts::kFollow);
    return true;
  }
  motion_count_ = 0;
  if (!params_.linear && !progress_.stopped()) {
    SetZero(last_f_);
    SetZero(good_u_);
    body_.ForgetRotations();
    Retreat(good_u_);
    if (SolveInParts(f_ext, constraints)) {
      Correct(constraints, Contacts::kFollow);
      return true;
    }
  }
  Retreat(last_u_);
  return false;
}

// Applies the whole load at once if Newton's method converges, else parts that are halved until it
// does.
bool StaticEquilibrium::SolveInParts(const NodeVector& f_ext,
                                     const Constraints& constraints) noexcept {
  good_u_ = u_;
  double done = 0, part = 1;
  while (done < 1) {
    const double next = std::min(1.0, done + part);
    f_ext_ = f_ext;
    Scale(next, f_ext_);
    Add(1 - next, last_f_, f_ext_);
    if (Iterate(constraints, (next - done) / (1 - done))) {
      good_u_ = u_;
      done = next;
      part *= 2;
      continue;
    }
    part /= 2;
    if (progress_.stopped() || part < kMinPart || params_.linear) return false;
    Retreat(good_u_);
  }
  last_f_ = f_ext;
  return true;
}

// Returns whether a contact with a force has ended. The body then moves although no contact moves,
// so this motion and those of the ended contact cannot predict the remaining contacts.
bool StaticEquilibrium::LetsGo(const Constraints& constraints) noexcept {
  if (!hyperelastic_ || !has_new_constraints_) return false;
  if (!is_current_) Update(With::kForces);
  f_ext_ = last_f_;
  return FreeResidual(constraints) > kLetGo * params_.residual * std::max(reference_, before_);
}

// Predicts by the combination of the last motions that fits the present motion of the contacts
// best. Each motion is first made orthogonal to newer ones.
void StaticEquilibrium::Predict(const Constraints& constraints) noexcept {
  is_predicted_ = false;
  if (!hyperelastic_) return;
  constraints.Lift(u_, 1, lift_);
  for (int k = 0; tools_ != nullptr && k < tools_->size(); ++k) {
    tools_->at(k).Carry(tools_->Way(k), &lift_);
  }
  const bool renews = std::exchange(has_new_constraints_, false);
  for (int i = 0; renews && i < motion_count_; ++i) FindHeld(constraints, &motions_[Index(i)]);
  for (int i = 0; i < motion_count_; ++i) {
    Motion& motion = motions_[Index(i)];
    for (int k = 0; k < i; ++k) {
      const Motion& newer = motions_[Index(k)];
      if (!newer.is_independent) continue;
      const double share =
          Dot(newer.contacts, motion.contacts) / Dot(newer.contacts, newer.contacts);
      Add(-share, newer.contacts, motion.contacts);
      Add(-share, newer.body, motion.body);
    }
    const double square = Dot(motion.contacts, motion.contacts);
    motion.is_independent = square > kIndependentMotion * motion.square;
    const double amount = Dot(motion.contacts, lift_) / square;
    if (!motion.is_independent || !(std::abs(amount) <= kMaxAhead)) continue;
    Add(-amount, motion.contacts, lift_);
    Add(amount, motion.body, u_);
    is_predicted_ = true;
  }
  if (!is_predicted_) return;
  Update(With::kTangent);
  if (summary_.inverted == 0 && std::isfinite(summary_.energy)) return;
  is_predicted_ = false;
  u_ = last_u_;
  is_current_ = false;
}

void StaticEquilibrium::FindHeld(const Constraints& constraints, Motion* motion) const noexcept {
  constraints.HeldPart(motion->body, motion->contacts);
  if (tools_ != nullptr) {
    tools_->Carry(std::span(motion->paths).first(Index(motion->path_count)), &motion->contacts);
  }
  motion->square = Dot(motion->contacts, motion->contacts);
}

void StaticEquilibrium::LearnMotion(const Constraints& constraints) noexcept {
  if (!hyperelastic_) return;
  std::rotate(motions_.begin(), motions_.end() - 1, motions_.end());
  Motion& motion = motions_[0];
  motion.body = u_;
  Add(-1, last_u_, motion.body);
  motion.path_count = 0;
  for (int k = 0; tools_ != nullptr && k < std::min(tools_->size(), static_cast<int>(kMaxPaths));
       ++k) {
    motion.paths[Index(motion.path_count++)] = tools_->Way(k);
  }
  FindHeld(constraints, &motion);
  motion_count_ = std::min(motion_count_ + 1, kMotions);
}

// The forces of the tools' springs at u_.
void StaticEquilibrium::LoadTools() noexcept {
  if (tools_ == nullptr) return;
  tools_->UpdateSprings(u_);
  tools_->Load(f_base_, &f_ext_);
}

// The friction at u_ of the nodes that slip, with the forces of the springs.
void StaticEquilibrium::FollowFriction(const Constraints& constraints) noexcept {
  if (tools_ == nullptr) return;
  LoadTools();
  FreeResidual(constraints);
  tools_->UpdateFriction(u_, reaction_);
  tools_->Load(f_base_, &f_ext_);
}

// The residual, less the forces of the lifts that close the gaps of the tools. Returns its norm.
double StaticEquilibrium::FindGapsAndResidual(const Constraints& constraints) noexcept {
  FreeResidual(constraints);
  SetZero(lift_);
  if (tools_ != nullptr) constraints.Lift(u_, 1, lift_);
  if (Norm(lift_) > kGapRounding) {
    tangent_.Multiply(lift_, gap_force_);
    constraints.ProjectForce(gap_force_);
    Add(-1, gap_force_, r_);
  }
  return Norm(r_);
}

// Solves for the residual that is left, with the last tangent, and takes the solution as one more
// step where no element is inverted and the residual falls. The change of the forces, times the
// share of the residual that is left, is then their error; else it is the change itself. If a
// contact of the tools changes, the search must go on.
StaticEquilibrium::Correction StaticEquilibrium::Correct(const Constraints& constraints,
                                                         Contacts contacts) noexcept {
  if (!hyperelastic_) return Correction::kRefused;
  const double size = FindGapsAndResidual(constraints);
  SetZero(x_);
  SetZero(trial_);
  if (!(size > 0)) return Correction::kMade;
  progress_.LimitTo(0);
  trial_ = r_;
  SolveWithFriction(constraints, kErrorShare * size);
  Add(1, lift_, x_);
  SetZero(trial_);
  const auto complete = [&](int row) { At(trial_, row) = tangent_.Row(row, x_); };
  if (!constraints.ForBearing(complete)) tangent_.Multiply(x_, trial_);
  const int inverted = summary_.inverted;
  good_u_ = u_;
  last_reaction_ = reaction_;
  Add(1, x_, u_);
  Update(With::kForces);
  FollowFriction(constraints);
  if (summary_.inverted > inverted || !(FindGapsAndResidual(constraints) < size)) {
    u_ = good_u_;
    Update(With::kForces);
    FollowFriction(constraints);
    relative_residual_ = FreeResidual(constraints) / std::max(reference_, released_);
    return Correction::kRefused;
  }
  if (motion_count_ > 0) Add(1, x_, motions_[0].body);
  bool changes = false;
  if (tools_ != nullptr && contacts == Contacts::kFollow) {
    changes = tools_->UpdateTouching(u_, reaction_, kDecisionShare * TargetResidual(),
                                     After::kCorrection);
    tools_->Load(f_base_, &f_ext_);
  }
  const double left = FindGapsAndResidual(constraints);
  relative_residual_ = left / std::max(reference_, released_);
  const double share = std::min(1.0, kLeftShare * left / size);
  Scale(share, x_);
  trial_ = reaction_;
  Add(-1, last_reaction_, trial_);
  Scale(share, trial_);
  return changes ? Correction::kContactsChange : Correction::kMade;
}

void StaticEquilibrium::Update(With with) noexcept {
  if (hyperelastic_ && with == With::kTangent) {
    summary_ = body_.EvaluateWithTangent(u_, shift_, tangent_);
    has_tangent_ = is_near_ = true;
    solver_.Follow();
  } else {
    summary_ = body_.Evaluate(u_);
    has_tangent_ = has_tangent_ && params_.linear;
  }
  body_.InternalForce(f_int_);
  is_current_ = true;
}

void StaticEquilibrium::PrepareTangent() noexcept {
  const bool keeps = std::exchange(keeps_tangent_, false);
  if (has_tangent_) return;
  is_near_ = false;
  if (keeps) return;
  if (hyperelastic_) {
    Update(With::kTangent);
  } else {
    body_.AssembleTangent(0, 1, tangent_);
    has_tangent_ = true;
    solver_.Follow();
  }
}

void StaticEquilibrium::Retreat(const NodeVector& to) noexcept {
  u_ = to;
  is_near_ = false;
  Update(With::kForces);
}

double StaticEquilibrium::Potential() const noexcept {
  return summary_.energy - Dot(f_ext_, u_);
}

// r_ = P^T (f_ext - f_int); its norm, and reaction_.
double StaticEquilibrium::FreeResidual(const Constraints& constraints) noexcept {
  r_ = f_int_;
  Add(-1, f_ext_, r_);
  reaction_ = r_;
  Scale(-1, r_);
  constraints.ProjectForce(r_);
  Add(1, r_, reaction_);
  const double size = Norm(r_);
  reference_ = std::max({Norm(f_ext_), Norm(reaction_), released_});
  Add(-1, r_, reaction_);
  return size;
}

// Iterates from u_ while the contacts move by `part` of their remaining displacement.
bool StaticEquilibrium::Iterate(const Constraints& constraints, double part) noexcept {
  if (!is_current_) Update(With::kTangent);
  progress_.LimitTo(0);
  released_ = kInner * before_;
  bool lifted = constraints.Lift(u_, 1, lift_) > 0;
  if (part < 1) Scale(part, lift_);
  double size = FreeResidual(constraints), previous = size;
  if (!lifted) released_ = std::max(released_, kInner * size);
  const double requested = Requested(), aim = TargetResidual() / requested;
  const int most = hyperelastic_ ? kMaxHyperelasticSteps : kMaxSteps;
  for (int step = 0; step < most && std::isfinite(size); ++step) {
    const double asked = requested * std::max(reference_, released_);
    relative_residual_ = size > 0 ? size / std::max(reference_, released_) : 0;
    const bool stalled = step > 0 && size > kStalled * previous;
    if (!lifted && (size <= aim * asked || (size <= asked && stalled))) return true;
    const bool is_little =
        step > 0 && !lifted && is_predicted_ && size <= kBySameTangent * aim * asked;
    if (is_little && corrects_) return true;
    ended_early_ = (!lifted || tools_ != nullptr) && step > 0 && progress_.late();
    if (ended_early_) return true;
    // Without a prediction the first step leaves more than the tangent makes it.
    const bool is_first = step == 0 && lifted && !is_predicted_;
    const bool serves = settles_ ? step == 0 || kBySameTangent * size <= previous
                                 : is_near_ && (is_first || is_little);
    keeps_tangent_ = keeps_tangent_ || (shift_ == 0 && serves);
    PrepareTangent();
    const double floor = RoundingFloor(tangent_, u_);
    if (!lifted && step > 0 && size <= floor) return true;
    previous = size;
    progress_.Reach(size, aim * asked);
    if (!progress_.Continue()) return false;
    ++newton_steps_;
    const double enough = std::max(floor, hyperelastic_ ? kLinearShare * aim * asked : 0);
    if (!Advance(constraints, lifted, enough)) return size <= asked && !lifted;
    progress_.LimitTo(kForSteps * params_.deadline);
    lifted = false;
    LoadTools();
    size = FreeResidual(constraints);
    if (tools_ == nullptr) continue;
    const double left = size;
    lifted = Touch(constraints);
    size = FreeResidual(constraints);
    keeps_tangent_ = size > kByContact * left;
  }
  return false;
}

// Updates the contact of the tools after a step: touching nodes and their friction. True: the tools
// move further nodes.
bool StaticEquilibrium::Touch(const Constraints& constraints) noexcept {
  const After after = settles_ ? After::kCorrection : After::kStep;
  if (tools_->UpdateTouching(u_, reaction_, TargetResidual(), after)) solver_.Follow();
  tools_->Load(f_base_, &f_ext_);
  return constraints.Lift(u_, 1, lift_) > 0;
}

// x_ of one step of Newton's method; `enough`: residual of its linear system.
bool StaticEquilibrium::FindDirection(const Constraints& constraints, bool lifted,
                                      double enough) noexcept {
  trial_ = r_;
  if (lifted) {
    tangent_.Multiply(lift_, x_);
    constraints.ProjectForce(x_);
    Add(-1, x_, trial_);
  }
  SetZero(x_);
  const double inner = params_.linear ? 0.5 * TargetResidual() : kInner;
  const double most = lifted && tools_ != nullptr ? kMotionShare * Norm(trial_) : enough;
  const double target = std::max(inner * Norm(trial_), std::min(enough, most));
  if (tools_ != nullptr) solver_.Follow();
  const SolveOutcome outcome = SolveWithFriction(constraints, target);
  iterations_ += outcome.iterations;
  return !outcome.indefinite;
}

// x_ with tangent_ x_ = trial_ + s_, where s_ is the change of friction that the normal reactions
// of lift_ + x_ cause. The tangent is symmetric and this relation is not: s_ is found by conjugate
// residuals (Eisenstat, Elman and Schultz, SIAM J. Numer. Anal. 20, 1983), truncated.
SolveOutcome StaticEquilibrium::SolveWithFriction(const Constraints& constraints,
                                                  double target) noexcept {
  SetZero(s_);
  if (tools_ == nullptr) return solver_.Solve(tangent_, constraints, trial_, x_, target);
  const auto change_of_friction = [&](const NodeVector& motion, NodeVector* change) {
    SetZero(*change);
    tools_->AddFrictionOf(motion, tangent_, change);
    constraints.ProjectForce(*change);
  };
  const auto solve = [&](NodeVector& r, NodeVector& x, double accuracy) {
    tools_->AddStiffness(1, &tangent_);
    const SolveOutcome outcome = solver_.Solve(tangent_, constraints, r, x, accuracy);
    tools_->AddStiffness(-1, &tangent_);
    return outcome;
  };
  SolveOutcome outcome = solve(trial_, x_, target);
  if (outcome.indefinite || !tools_->slips()) return outcome;
  p_ = x_;
  Add(1, lift_, p_);
  change_of_friction(p_, &left_);
  const double sufficient = std::max(target, kFollowed * Norm(left_));
  int known = 0;
  for (int k = 0; k < kFollowSolutions && Norm(left_) > sufficient; ++k) {
    FrictionStep& step = friction_steps_[Index(k % kFrictionSteps)];
    p_ = step.load = left_;
    SetZero(step.x);
    const SolveOutcome one = solve(p_, step.x, std::max(0.5 * sufficient, kInner * Norm(left_)));
    outcome.iterations += one.iterations;
    if (one.indefinite) break;
    change_of_friction(step.x, &p_);
    step.change = step.load;
    Add(-1, p_, step.change);
    for (int i = 0; i < known; ++i) {
      const FrictionStep& other = friction_steps_[Index(i)];
      if (&other == &step) continue;
      const double share = Dot(other.change, step.change) / Dot(other.change, other.change);
      Add(-share, other.change, step.change);
      Add(-share, other.x, step.x);
      Add(-share, other.load, step.load);
    }
    const double square = Dot(step.change, step.change);
    if (!(square > 0)) break;
    const double amount = Dot(step.change, left_) / square;
    Add(amount, step.x, x_);
    Add(amount, step.load, s_);
    Add(-amount, step.change, left_);
    known = std::min(known + 1, kFrictionSteps);
  }
  return outcome;
}

// One step of Newton's method.
bool StaticEquilibrium::Advance(const Constraints& constraints, bool lifted,
                                double enough) noexcept {
  if (shift_ > 0) shift_ = shift_ > kMinShift ? shift_ / 4 : 0;
  while (!FindDirection(constraints, lifted, enough)) {
    if (hyperelastic_) shift_ = std::max(4 * shift_, kMinShift);
    if (shift_ > kMaxShift) return false;
    if (hyperelastic_) Update(With::kTangent);
    solver_.Renew();
    if (!hyperelastic_) {
      FindDirection(constraints, lifted, enough);
      break;
    }
  }
  // The search along x_ has the friction of its end.
  Add(1, s_, r_);
  Add(1, s_, f_ext_);
  const double size = Norm(r_), energy = Potential(), slope = Dot(r_, x_);
  const bool began_inverted = summary_.inverted > 0;
  trial_ = u_;
  if (lifted) Add(1, lift_, x_);
  double length = 1;
  for (int halving = 0; halving < kMaxHalvings; ++halving, length *= 0.5) {
    u_ = trial_;
    Add(length, x_, u_);
    Update(lifted && !is_predicted_ ? With::kTangent : With::kForces);
    if (lifted || params_.linear) return std::isfinite(summary_.energy);
    // Equilibria with inverted elements cannot be reached by a slow load.
    if (hyperelastic_ && !began_inverted && summary_.inverted > 0) continue;
    if (Potential() <= energy - kSufficient * length * slope) return true;
    if (FreeResidual(constraints) < (1 - kSufficient * length) * size) return true;
  }
  Retreat(trial_);
  FreeResidual(constraints);
  return false;
}

}  // namespace palpate::fem
