// Linear systems with the tangent of a body: conjugate gradients in double precision among the
// possible motions, preconditioned by a factor of an earlier tangent or, for large bodies, by a
// cycle of two grids; in statics these also get a factor, after the iterations have taken as long
// as a factorisation would.
#pragma once

#include <array>
#include <memory>
#include <optional>
#include <vector>

#include <Eigen/Core>

#include "slave/mechanics/fem/constraints.h"
#include "slave/mechanics/fem/fem_body.h"
#include "slave/mechanics/fem/held_tangent.h"
#include "slave/mechanics/fem/search_progress.h"
#include "slave/mechanics/linear/block_matrix.h"
#include "slave/mechanics/linear/sparse_ldlt.h"
#include "slave/mechanics/linear/two_grid.h"

namespace palpate::fem {

struct SolveOutcome {
  bool converged = false;
  // The iterations met a direction of negative curvature; x is the iterate before it.
  bool indefinite = false;
  int iterations = 0;
};

class LinearSolver {
 public:
  static constexpr double kAnyFlops = 1e300;
  struct Params {
    // A factor in single precision will do where it exists, as where tangents change and it ages
    // anyway.
    bool single = false;
    // Large bodies get a single-precision factor when it saves time.
    bool late_factor = false;
    double max_flops = kAnyFlops;  // of a factor that goes first
    // Grids receive every matrix by Follow, and iterate with their own copy of it.
    bool follows = false;
    SearchProgress* progress = nullptr;  // asked on the way whether to stop; may be null
  };
  LinearSolver(const FemBody& body, const Params& params);

  // The next Solve factors again: the matrix is another one.
  void Renew() noexcept { due_ = true; }
  // The set of fixed components has changed as well.
  void Reset() noexcept;
  // The matrix or the fixed components changed so little that a factor serves. Grids take them.
  void Follow() noexcept { follows_ = true; }
  // A x = b: `r` is P^T (b - A x) on entry and exit, x changes within the possible motions until
  // the norm of r is at most `target`. Allocation-free.
  SolveOutcome Solve(const BlockMatrix& A, const Constraints& constraints, NodeVector& r,
                     NodeVector& x, double target) noexcept;

  [[nodiscard]] bool direct() const { return direct_; }
  [[nodiscard]] std::size_t memory_bytes() const;

 private:
  enum class Kind { kNone, kSingle, kDouble, kGrids, kDiagonal };

  void Prepare(const BlockMatrix& A, const HeldComponents& held, Kind kind) noexcept;
  bool Factor(const BlockMatrix& A, const HeldComponents& held, Kind kind) noexcept;
  void PrepareGrids(const BlockMatrix& A, const HeldComponents& held) noexcept;
  void FollowMatrix(const BlockMatrix& A, const HeldComponents& held) noexcept;
  [[nodiscard]] bool has_factor() const { return kind_ == Kind::kSingle || kind_ == Kind::kDouble; }
  void InvertDiagonal(const BlockMatrix& A, const HeldComponents& held) noexcept;
  void Precondition(const Constraints& constraints, const NodeVector& r, NodeVector& z) noexcept;
  SolveOutcome Iterate(const BlockMatrix& A, const Constraints& constraints, NodeVector& r,
                       NodeVector& x, double target) noexcept;
  SolveOutcome IterateOnGrids(NodeVector& r, NodeVector& x, double target) noexcept;
  // Iterations after which another way of solving is cheaper.
  [[nodiscard]] int MaxIterations() const;
  void CountAge(int iterations, double digits) noexcept;
  // Computes `turns_`: the rotation of each node since the matrix of the factor.
  void FindTurns() noexcept;
  void TurnBack(const NodeVector& r, NodeVector& turned) const noexcept;
  void Turn(NodeVector& z) const noexcept;
  // A part of the factor that replaces an aged one.
  void ContinueNext(const BlockMatrix& A, const HeldComponents& held) noexcept;
  [[nodiscard]] bool Stopped() const {
    return progress_ != nullptr && (progress_->stopped() || progress_->late());
  }

  const FemBody& body_;
  SearchProgress* progress_;
  bool direct_ = false;
  bool follows_all_ = false;          // see Params
  bool late_factor_ = false;          // the grids go first
  bool factorable_ = true;            // as far as is known
  int spent_ = 0;                     // iterations with the grids
  int late_worth_ = 0;                // of the late factor, in such
  std::optional<HeldTangent> upper_;  // of the matrix that is factored
  std::unique_ptr<SparseLdlt<float>> single_factor_;
  // Replaces an outdated factor while it is in use. Each solution computes a part of the new
  // factor, from the matrix at the time of the first part, so that no time step takes much longer
  // than others.
  enum class Next { kNone, kDue, kBegun };
  Next next_ = Next::kNone;
  std::unique_ptr<SparseLdlt<float>> next_factor_;  // null: outdated factors are replaced at once
  // An outdated factor is used in axes that rotate with the nodes, because rotations are most of
  // the change of a tangent in large motions.
  NodeVector rotations_, next_rotations_;  // when the matrices of the two were new
  NodeVector now_;                         // and now
  std::vector<Eigen::Matrix3d> turns_;
  std::optional<SparseLdlt<double>> double_factor_;  // or where single precision fails
  Eigen::VectorXf single_x_;                         // a right side, then its solution
  Eigen::VectorXd double_x_;
  std::optional<TwoGrid> grids_;        // of large bodies
  bool coarse_serves_ = false;          // of the grids, for later matrices too
  bool renewed_ = false;                // the fine grid, since the coarse one was made
  bool follows_ = false;                // reuses data of another matrix
  double young_rate_ = 0;               // smallest number of iterations per digit with these grids
  std::vector<double> inverse_blocks_;  // nine per row, used if all other preconditioners fail
  Kind kind_ = Kind::kNone;
  bool due_ = true;
  int young_iterations_ = -1;  // of the first solution after factoring
  double excess_ = 0;          // iterations beyond those, since
  double refactor_worth_ = 0;  // in iterations
  NodeVector z_, p_, q_;
};

// A first guess from the last solutions: the best combination of the last one and its first and
// second differences in the norm of the matrix. Source: Fischer (1998).
class SolutionHistory {
 public:
  explicit SolutionHistory(int nodes);

  void Clear() noexcept { known_ = 0; }
  void Keep(const NodeVector& solution) noexcept;
  // Computes product = A x, and the parts of A that Improve needs.
  void Multiply(const BlockMatrix& A, const Constraints& constraints, const NodeVector& x,
                NodeVector& product) noexcept;
  // x += guess, r -= P^T A guess; `r` = P^T (b - A x).
  void Improve(NodeVector& r, NodeVector& x) noexcept;

 private:
  static constexpr int kDepth = 3;

  int known_ = 0;
  std::array<NodeVector, kDepth> differences_;  // of rising order
  std::array<NodeVector, kDepth> directions_, products_;
  NodeVector change_;
};

}  // namespace palpate::fem
