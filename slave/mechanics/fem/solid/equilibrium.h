// Finds where the forces on a body balance: Newton's method with a line search on the energy, the
// linear law in one solve with refinement.
//
//   gradient W(x) + Q (x - x_0) = f + q + C^T m,   x = given on fixed unknowns,   C x = c
//
// Q and q carry the inertia of a time step that began at x_0 (none in statics), m are the
// forces of contacts that move a point between nodes. Nondimensional.
#pragma once

#include <optional>
#include <string_view>
#include <utility>
#include <vector>

#include <Eigen/Cholesky>
#include <Eigen/Core>

#include "slave/mechanics/fem/solid/elastic_body.h"
#include "slave/mechanics/fem/solid/pressure_update.h"
#include "slave/mechanics/fem/solid/sparse_system.h"

namespace palpate {

// One row of C: unknowns of one element and their weights.
struct PointRow {
  std::vector<std::pair<int, double>> weights;
  double value = 0;  // prescribed sum
};

struct Balance {
  Eigen::VectorXd force;    // f + q
  std::vector<char> fixed;  // per unknown
  Eigen::VectorXd given;    // values of fixed unknowns
  std::vector<PointRow> rows;
  Eigen::VectorXd row_force;                // m, found
  const SparseMatrix* inertia = nullptr;    // Q
  const Eigen::VectorXd* origin = nullptr;  // x_0
};

class Equilibrium {
 public:
  struct Options {
    double residual = 1e-6;  // relative to the largest of loads, reactions and point forces
    // A time step: one linear solve without line search, with a tangent for constant rotations of
    // the co-rotational law.
    bool one_solve = false;
    SymmetricSolver::Limits limits;
    // For long searches; may be null, else must outlive this.
    fem::SearchProgress* progress = nullptr;
  };
  // Stores references to its arguments. The linear law assembles its matrix here.
  Equilibrium(const BlockLayout& layout, const ElasticBody& body, const Options& options);

  // Moves x, a state near the solution, to equilibrium. False: failure() is the reason, x is
  // unusable. Allocates only when `rows` grow, and for the factorisation.
  bool Solve(Balance* balance, Eigen::VectorXd* x);
  // Call when fixed unknowns, rows or inertia differ from the last Solve.
  void Changed() { factored_ = rows_.has_columns = false; }

  // gradient W + Q (x - x_0) - f - q of the last state: the reactions of fixed unknowns and points.
  [[nodiscard]] const Eigen::VectorXd& unbalanced() const { return residual_; }
  [[nodiscard]] int newton_steps() const { return steps_; }
  [[nodiscard]] std::string_view failure() const { return failure_; }
  [[nodiscard]] const SymmetricSolver& solver() const { return solver_; }
  // Elastic energy W(x).
  double Energy(const Eigen::VectorXd& x);

 private:
  [[nodiscard]] bool linear() const { return body_.law().law() == FemOptions::Law::kLinear; }
  double Residual(const Balance& balance, const Eigen::VectorXd& x);
  double Potential(const Balance& balance, const Eigen::VectorXd& x);
  double Weigh(const Balance& balance);
  bool Prepare(Balance* balance, const Eigen::VectorXd& x, bool first);
  bool FactorTangent(const Balance& balance, const Eigen::VectorXd& x, const Tangent& tangent,
                     bool first);
  void Constrain(const Balance& balance);
  bool PrepareRows(const Balance& balance);
  [[nodiscard]] double Accuracy() const;
  bool Direction(Balance* balance, const Eigen::VectorXd& x, bool first);
  bool Search(const Balance& balance, double slope, Eigen::VectorXd* x);
  bool KeepsVolume(const Eigen::VectorXd& x);
  bool Iterate(Balance* balance, Eigen::VectorXd* x);
  bool Fail(std::string_view why) {
    failure_ = why;
    return false;
  }

  const BlockLayout& layout_;
  const ElasticBody& body_;
  Options options_;
  SymmetricSolver solver_;
  // Stiffness without constraints: constant for the linear law, else that at the start of a
  // solution.
  SparseMatrix stiffness_;
  SparseMatrix system_;  // the factorised matrix
  // Rows of moved points.
  struct Rows {
    std::optional<Eigen::LDLT<Eigen::MatrixXd>> factor;
    Eigen::MatrixXd matrix, columns;  // C A^-1 C^T, A^-1 C^T
    bool has_columns = false;
    double penalty = 0;
  } rows_;

  // Present if the pressure is an unknown and the law is not linear.
  std::optional<PressureUpdate> pressure_;

  Eigen::VectorXd residual_, right_, step_, trial_, product_;
  double energy_ = 0, relative_ = 0, start_force_ = 0, removed_ = 0;
  int steps_ = 0, expected_negative_ = 0;
  bool factored_ = false;
  bool raised_ = false;  // the last step changed the removed curvature
  std::string_view failure_;
};

}  // namespace palpate
