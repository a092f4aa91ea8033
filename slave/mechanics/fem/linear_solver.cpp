#include "slave/mechanics/fem/linear_solver.h"

#include <algorithm>
#include <cmath>
#include <utility>

#include <Eigen/Core>
#include <Eigen/Geometry>
#include <Eigen/LU>

#include "slave/mesh/index.h"

namespace palpate::fem {
namespace {

constexpr std::size_t kMaxEntries = 12'000'000;  // of a factor
// Largest number of entries of a factor that is stored in both precisions.
constexpr std::size_t kMaxEntriesTwice = 2'000'000;
constexpr std::size_t kMaxEntriesLate = 300'000'000;  // of a late one
// Ratio of the speeds of multiplications in a factorisation and in a solution, which is limited by
// memory.
constexpr double kFactorSpeed = 4;
// Operations of a factorisation done in the time that an iteration takes per block.
constexpr double kLateSpeed = 600;
// Relative rounding error of a residual [-]: a smaller residual may be inconsistent with the
// constraints, and iterating on it would spoil the answer.
constexpr double kResidualRounding = 2e-15;
constexpr double kTiny = 1e-300;
// Smallest target, relative to the right-hand side, that single precision can reach: its rounding
// leaves 1e-6 [-].
constexpr double kSingleDigits = 1e-4;
constexpr double kGridsWorth = 20;  // iterations that take as long as new grids
// Number of solutions over which a factor is replaced step by step, and the fraction of its cost
// after which the replacement begins early. [tuned: SwingingStep]
constexpr double kParts = 8, kEarly = 0.5;
constexpr int kMaxIterations = 20'000;
constexpr int kMaxWithFactor = 400;  // iterations with a factor above which a new one is made
constexpr int kMaxStagnant = 1'000;  // iterations without a better residual

double LargestDiagonal(const BlockMatrix& A) {
  double largest = 0;
  for (const int k : A.pattern().diagonal) {
    const double* block = A.block(k);
    largest = std::max({largest, block[0], block[4], block[8]});
  }
  return largest;
}

template <typename Scalar>
void SolveWith(SparseLdlt<Scalar>& factor, const NodeVector& r, NodeVector& z,
               Eigen::Matrix<Scalar, Eigen::Dynamic, 1>* x) {
  for (Eigen::Index i = 0; i < x->size(); ++i) {
    (*x)[i] = static_cast<Scalar>(r[static_cast<std::size_t>(i / 3)].v[i % 3]);
  }
  factor.Solve(x);
  for (Eigen::Index i = 0; i < x->size(); ++i) {
    z[static_cast<std::size_t>(i / 3)].v[i % 3] = static_cast<double>((*x)[i]);
  }
}

// Smallest remaining share of a direction's square after orthogonalisation.
constexpr double kIndependentDirection = 1e-8;

}  // namespace

LinearSolver::LinearSolver(const FemBody& body, const Params& params)
    : body_(body),
      progress_(params.progress),
      follows_all_(params.follows),
      inverse_blocks_(9 * Index(body.moving())),
      z_(Index(body.size())),
      p_(Index(body.size())),
      q_(Index(body.size())) {
  upper_.emplace(body.pattern());
  double_factor_.emplace(upper_->upper());
  const auto entries = double_factor_->entries();
  direct_ = entries <= kMaxEntries && double_factor_->flops() <= params.max_flops;
  refactor_worth_ = double_factor_->flops() / (2 * kFactorSpeed * static_cast<double>(entries));
  late_factor_ = params.late_factor && !direct_ && entries <= kMaxEntriesLate;
  late_worth_ = static_cast<int>(
      std::min(1e9, double_factor_->flops() / (kLateSpeed * body.pattern().blocks())));
  if ((params.single && direct_) || late_factor_) {
    single_factor_ = std::make_unique<SparseLdlt<float>>(upper_->upper());
    single_factor_->Allocate(upper_->upper());
    single_x_.resize(upper_->upper().cols());
  }
  if (params.single && direct_) {
    next_factor_ = std::make_unique<SparseLdlt<float>>(upper_->upper());
    next_factor_->Allocate(upper_->upper());
    for (auto* of : {&rotations_, &next_rotations_, &now_}) of->resize(Index(body.moving()));
    turns_.resize(Index(body.moving()));
  }
  if (!direct_) {
    grids_.emplace(std::span(body.points()).first(Index(body.moving())), body.pattern());
    refactor_worth_ = kGridsWorth;
  }
  if (!direct_ || (params.single && entries > kMaxEntriesTwice)) {
    double_factor_.reset();
  } else {
    double_factor_->Allocate(upper_->upper());
    double_x_.resize(upper_->upper().cols());
  }
  if (!single_factor_ && !double_factor_) upper_.reset();
}

void LinearSolver::Reset() noexcept {
  due_ = true;
  factorable_ = true;
  spent_ = 0;
  kind_ = Kind::kNone;
}

std::size_t LinearSolver::memory_bytes() const {
  std::size_t bytes = inverse_blocks_.size() * sizeof(double) + 3 * z_.size() * sizeof(NodeValue);
  if (single_factor_) bytes += single_factor_->memory_bytes();
  if (next_factor_) bytes += next_factor_->memory_bytes();
  if (upper_) bytes += upper_->memory_bytes();
  if (double_factor_) bytes += double_factor_->memory_bytes();
  if (grids_) bytes += grids_->memory_bytes();
  return bytes;
}

SolveOutcome LinearSolver::Solve(const BlockMatrix& A, const Constraints& constraints,
                                 NodeVector& r, NodeVector& x, double target) noexcept {
  const bool was_due = due_ || (late_factor_ && !has_factor() && spent_ >= late_worth_);
  if (was_due) Prepare(A, constraints.held(), Kind::kSingle);
  if (std::exchange(follows_, false) && !was_due) FollowMatrix(A, constraints.held());
  if (next_ != Next::kNone) ContinueNext(A, constraints.held());
  const double digits = std::log10(Norm(r) / std::max(target, kTiny));
  SolveOutcome outcome = Iterate(A, constraints, r, x, target);
  int before = 0;
  // A factor that is too old or not precise enough is replaced by a better one, and the diagonal
  // preconditioner by a factor.
  for (const Kind better : {Kind::kSingle, Kind::kDouble}) {
    if (outcome.converged || outcome.indefinite || Stopped()) break;
    if (!has_factor()) {
      if (!late_factor_ || !factorable_) break;
      spent_ = late_worth_;
    }
    Prepare(A, constraints.held(), better);
    before += outcome.iterations;
    outcome = Iterate(A, constraints, r, x, target);
  }
  CountAge(outcome.iterations, digits);
  outcome.iterations += before;
  return outcome;
}

void LinearSolver::Prepare(const BlockMatrix& A, const HeldComponents& held, Kind kind) noexcept {
  due_ = false;
  next_ = Next::kNone;
  if (!late_factor_ || (factorable_ && spent_ >= late_worth_)) {
    if (Factor(A, held, kind)) return;
    factorable_ = Stopped();
  }
  PrepareGrids(A, held);
}

// Components that an outdated factor wrongly fixes or frees need a few iterations, which add to its
// age. If the grids do not fit a matrix, they are tried again with the next one.
void LinearSolver::FollowMatrix(const BlockMatrix& A, const HeldComponents& held) noexcept {
  if (has_factor()) return;
  renewed_ = kind_ == Kind::kGrids && grids_->Renew(A, held.free, held.guides);
  if (renewed_) return;
  InvertDiagonal(A, held);
  due_ = grids_.has_value();
}

// Outdated grids get the new matrix; if this is not sufficient, the coarse grid is rebuilt, too. A
// coarse grid from before a contact would move the nodes that the contact fixes.
void LinearSolver::PrepareGrids(const BlockMatrix& A, const HeldComponents& held) noexcept {
  const bool aged = excess_ > refactor_worth_;
  const bool coarse_serves = coarse_serves_ && !(aged && renewed_) &&
                             (kind_ != Kind::kNone || grids_->CoarseFixes(held.free));
  renewed_ = coarse_serves && aged;
  young_iterations_ = -1;
  if (!renewed_) young_rate_ = 0;
  excess_ = 0;
  coarse_serves_ = grids_ && (coarse_serves ? grids_->Renew(A, held.free, held.guides)
                                            : grids_->Factor(A, held.free, held.guides));
  if (coarse_serves_) {
    kind_ = Kind::kGrids;
  } else {
    InvertDiagonal(A, held);
  }
}

void LinearSolver::CountAge(int iterations, double digits) noexcept {
  if (kind_ == Kind::kDiagonal) return;
  if (kind_ == Kind::kGrids) {  // the accuracy of solutions differs
    if (iterations == 0 || !(digits > 0)) return;
    const double rate = iterations / digits;
    young_rate_ = young_rate_ > 0 ? std::min(young_rate_, rate) : rate;
    excess_ += iterations - young_rate_ * digits;
    due_ = due_ || excess_ > refactor_worth_;
    return;
  }
  if (young_iterations_ < 0) {
    young_iterations_ = iterations;
    return;
  }
  excess_ += iterations - young_iterations_;
  const bool in_parts = next_factor_ != nullptr && kind_ == Kind::kSingle;
  if (excess_ <= (in_parts ? kEarly : 1) * refactor_worth_) return;
  if (!in_parts) {
    due_ = true;
  } else if (next_ == Next::kNone) {
    next_ = Next::kDue;
  }
}

void LinearSolver::ContinueNext(const BlockMatrix& A, const HeldComponents& held) noexcept {
  if (next_ == Next::kDue) {
    body_.NodeRotations(next_rotations_);
    upper_->Fill(A, 1 / LargestDiagonal(A), held);
    next_factor_->Begin(upper_->upper(), true);
    next_ = Next::kBegun;
    return;
  }
  using Progress = SparseLdlt<float>::Progress;
  const Progress progress = next_factor_->Continue(next_factor_->flops() / kParts);
  if (progress == Progress::kMore) return;
  next_ = Next::kNone;
  if (progress == Progress::kFailed) return Prepare(A, held, Kind::kSingle);
  single_factor_.swap(next_factor_);
  rotations_.swap(next_rotations_);
  young_iterations_ = -1;
  excess_ = 0;
}

// Factors in single precision if that is requested and possible, else in double precision.
bool LinearSolver::Factor(const BlockMatrix& A, const HeldComponents& held, Kind kind) noexcept {
  if (!upper_) return false;  // the factor would be too large
  young_iterations_ = -1;
  excess_ = 0;
  upper_->Fill(A, 1 / LargestDiagonal(A), held);
  const auto go_on = [this](double done) {
    return progress_ == nullptr || progress_->ContinueFactor(done);
  };
  kind_ = Kind::kSingle;
  if (next_factor_) body_.NodeRotations(rotations_);
  if (kind == Kind::kSingle && single_factor_ &&
      single_factor_->Factorize(upper_->upper(), true, go_on)) {
    return true;
  }
  kind_ = Kind::kDouble;
  return double_factor_ && double_factor_->Factorize(upper_->upper(), true, go_on);
}

void LinearSolver::FindTurns() noexcept {
  body_.NodeRotations(now_);
  const auto matrix = [](const NodeValue& q) {
    return Eigen::Quaterniond(q.v[0], q.v[1], q.v[2], q.v[3]).toRotationMatrix();
  };
  for (int i = 0; i < body_.moving(); ++i) {
    turns_[Index(i)].noalias() = matrix(At(now_, i)) * matrix(At(rotations_, i)).transpose();
  }
}

void LinearSolver::TurnBack(const NodeVector& r, NodeVector& turned) const noexcept {
  for (int i = 0; i < body_.moving(); ++i) {
    Eigen::Map<Eigen::Vector3d>(At(turned, i).v) =
        turns_[Index(i)].transpose() * Eigen::Map<const Eigen::Vector3d>(At(r, i).v);
  }
}

void LinearSolver::Turn(NodeVector& z) const noexcept {
  for (int i = 0; i < body_.moving(); ++i) {
    Eigen::Map<Eigen::Vector3d> of(At(z, i).v);
    of = (turns_[Index(i)] * of).eval();
  }
}

void LinearSolver::InvertDiagonal(const BlockMatrix& A, const HeldComponents& held) noexcept {
  kind_ = Kind::kDiagonal;
  for (int i = 0; i < body_.moving(); ++i) {
    Eigen::Matrix3d block =
        Eigen::Map<const Eigen::Matrix3d>(A.block(A.pattern().diagonal[Index(i)]));
    for (int c = 0; c < 3; ++c) {
      if (At(held.free, i).v[c] > 0) continue;
      block.row(c).setZero();
      block.col(c).setZero();
      block(c, c) = 1;
    }
    Eigen::Map<Eigen::Matrix3d> inverse(&inverse_blocks_[9 * Index(i)]);
    inverse = block.inverse();
  }
}

void LinearSolver::Precondition(const Constraints& constraints, const NodeVector& r,
                                NodeVector& z) noexcept {
  if (kind_ == Kind::kSingle && next_factor_) {
    TurnBack(r, q_);
    SolveWith(*single_factor_, q_, z, &single_x_);
    Turn(z);
  } else if (kind_ == Kind::kSingle) {
    SolveWith(*single_factor_, r, z, &single_x_);
  } else if (kind_ == Kind::kDouble) {
    SolveWith(*double_factor_, r, z, &double_x_);
  } else if (kind_ == Kind::kGrids) {
    grids_->Solve(r, z);
  } else {
    for (int i = 0; i < body_.moving(); ++i) {
      const Eigen::Map<const Eigen::Matrix3d> inverse(&inverse_blocks_[9 * Index(i)]);
      const Eigen::Map<const Eigen::Vector3d> force(At(r, i).v);
      Eigen::Map<Eigen::Vector3d> motion(At(z, i).v);
      motion = inverse * force;
    }
  }
  constraints.ProjectMotion(z);
}

SolveOutcome LinearSolver::Iterate(const BlockMatrix& A, const Constraints& constraints,
                                   NodeVector& r, NodeVector& x, double target) noexcept {
  if (follows_all_ && kind_ == Kind::kGrids && constraints.AreOfNodes() &&
      target > kSingleDigits * Norm(r)) {
    return IterateOnGrids(r, x, target);
  }
  SolveOutcome outcome;
  const int most = MaxIterations();
  double best = Norm(r);
  const double reachable = std::max(target, kResidualRounding * best);
  int best_at = 0;
  double rho = 0;
  for (; outcome.iterations < most; ++outcome.iterations) {
    const double size = Norm(r);
    if (size <= reachable) {
      outcome.converged = true;
      break;
    }
    if (progress_ != nullptr) {
      progress_->ReachInner(size, target);
      if (!progress_->Continue() || progress_->late()) break;
    }
    if (size < best) best = size, best_at = outcome.iterations;
    if (!std::isfinite(size) || outcome.iterations - best_at > kMaxStagnant) break;
    if (outcome.iterations == 0 && kind_ == Kind::kSingle && next_factor_) FindTurns();
    Precondition(constraints, r, z_);
    const double next = Dot(r, z_);
    if (!(next > 0)) {  // or rounding
      outcome.indefinite = !(next == 0);
      break;
    }
    if (outcome.iterations == 0) {
      p_ = z_;
    } else {
      ScaleAndAdd(next / rho, z_, p_);
    }
    rho = next;
    A.Multiply(p_, q_);
    constraints.ProjectForce(q_);
    const double curvature = Dot(p_, q_);
    if (!(curvature > 0)) {
      outcome.indefinite = curvature < 0;
      break;
    }
    Add(rho / curvature, p_, x);
    Add(-rho / curvature, q_, r);
  }
  if (!has_factor()) spent_ += outcome.iterations;
  return outcome;
}

int LinearSolver::MaxIterations() const {
  if (has_factor()) return kMaxWithFactor;
  return late_factor_ && factorable_ ? std::max(0, late_worth_ - spent_) : kMaxIterations;
}

SolveOutcome LinearSolver::IterateOnGrids(NodeVector& r, NodeVector& x, double target) noexcept {
  SolveOutcome outcome;
  const int most = MaxIterations();
  for (grids_->Begin(r); outcome.iterations < most; ++outcome.iterations) {
    const double size = grids_->residual();
    outcome.converged = size <= target;
    if (outcome.converged) break;
    if (progress_ != nullptr) {
      progress_->ReachInner(size, target);
      if (!progress_->Continue() || progress_->late()) break;
    }
    if (!std::isfinite(size) || outcome.iterations > kMaxStagnant) break;
    const double positive = grids_->Iterate();
    if (positive > 0) continue;
    outcome.indefinite = positive != 0;
    break;
  }
  grids_->End(r, x);
  spent_ += outcome.iterations;
  return outcome;
}

SolutionHistory::SolutionHistory(int nodes) : change_(Index(nodes)) {
  for (auto* set : {&differences_, &directions_, &products_}) {
    for (auto& x : *set) x.resize(Index(nodes));
  }
}

void SolutionHistory::Keep(const NodeVector& solution) noexcept {
  change_ = solution;
  known_ = std::min(known_ + 1, kDepth);
  for (auto& difference : differences_) {
    std::swap(difference, change_);  // change_ now contains the older difference of this order
    for (std::size_t i = 0; i < change_.size(); ++i) {
      for (std::size_t c = 0; c < 3; ++c) change_[i].v[c] = difference[i].v[c] - change_[i].v[c];
    }
  }
}

void SolutionHistory::Multiply(const BlockMatrix& A, const Constraints& constraints,
                               const NodeVector& x, NodeVector& product) noexcept {
  if (known_ == 0) return A.Multiply(x, product);
  for (int k = 0; k < known_; ++k) {
    directions_[Index(k)] = differences_[Index(k)];
    constraints.ProjectMotion(directions_[Index(k)]);
  }
  A.Multiply({&x, &directions_[0], &directions_[1], &directions_[2]},
             {&product, &products_[0], &products_[1], &products_[2]});
  for (int k = 0; k < known_; ++k) constraints.ProjectForce(products_[Index(k)]);
}

void SolutionHistory::Improve(NodeVector& r, NodeVector& x) noexcept {
  std::array<int, kDepth> kept{};
  int count = 0;
  for (int k = 0; k < known_; ++k) {
    NodeVector &d = directions_[Index(k)], &product = products_[Index(k)];
    const double before = Dot(d, product);
    for (int l = 0; l < count; ++l) {
      const auto at = Index(kept[Index(l)]);
      const double share = Dot(directions_[at], product) / Dot(directions_[at], products_[at]);
      Add(-share, directions_[at], d);
      Add(-share, products_[at], product);
    }
    const double square = Dot(d, product);
    if (!(square > kIndependentDirection * before)) continue;
    const double amount = Dot(d, r) / square;
    Add(amount, d, x);
    Add(-amount, product, r);
    kept[Index(count++)] = k;
  }
}

}  // namespace palpate::fem
