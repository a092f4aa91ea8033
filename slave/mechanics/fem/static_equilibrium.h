// Equilibrium of a body at rest: f_int(u) = f_ext among the possible motions. Newton's method with
// a line search on the potential energy finds it. It uses the exact tangent of the neo-Hookean law,
// and the warped one of other laws. A query starts from a prediction: the combination of the last
// motions of the body that moves the contacts most nearly as they move now. With one step per query
// the error is then small. One more linear solution corrects it, and what that leaves is estimated.
#pragma once

#include <array>

#include "slave/mechanics/fem/constraints.h"
#include "slave/mechanics/fem/fem_body.h"
#include "slave/mechanics/fem/linear_solver.h"
#include "slave/mechanics/fem/search_progress.h"
#include "slave/mechanics/fem/tool_contacts.h"
#include "slave/mechanics/linear/block_matrix.h"

namespace palpate::fem {

class StaticEquilibrium {
 public:
  struct Params {
    double residual = 1e-6;  // relative to the norm of loads and reactions
    bool linear = false;
    // Time after which the best answer so far is returned [s]. At least one step with a whole
    // linear solution is made. 0: no deadline.
    double deadline = 0;
    Progress* progress = nullptr;  // for long searches; may be null, else must outlive this
  };
  // Stores a reference to the body.
  StaticEquilibrium(FemBody& body, const Params& params);

  // Returns to the state after construction: at rest.
  void Reset() noexcept;
  // Call this when contacts prescribe other components than before.
  void Renew() noexcept {
    solver_.Reset();
    has_new_constraints_ = true;
  }
  // Finds u for the forces and constraints. The search starts from the last u, then from rest, and
  // then applies parts of the load one after the other. Returns false if no u was found, or the
  // search was stopped: the last equilibrium is kept.
  bool Solve(const NodeVector& f_ext, const Constraints& constraints) noexcept;
  // Solves with tools in increments of their path. Call Begin, then Increment with all loads at the
  // end of the increment, and End after the last one. The contact of the tools is updated between
  // the steps. False: no equilibrium was found, and the last one is kept.
  void Begin() noexcept;
  // Stores the equilibrium, and returns to the stored one.
  void Keep() noexcept { kept_u_ = u_; }
  void TakeBack() noexcept;
  // `is_last`: End follows, so its corrections do the last steps.
  bool Increment(const NodeVector& f_ext, const Constraints& constraints, ToolContacts& tools,
                 bool is_last) noexcept;
  // Corrects the last increment, which the tools have accepted.
  void End(const Constraints& constraints, ToolContacts& tools) noexcept;
  [[nodiscard]] bool late() const noexcept { return progress_.late(); }

  [[nodiscard]] bool interrupted() const { return progress_.stopped(); }
  [[nodiscard]] const NodeVector& displacement() const { return u_; }
  // f_int - f_ext: the forces of supports and contacts.
  [[nodiscard]] const NodeVector& reaction() const { return reaction_; }
  [[nodiscard]] const ElementSummary& summary() const { return summary_; }
  [[nodiscard]] double residual() const { return relative_residual_; }
  [[nodiscard]] bool ended_early() const { return ended_early_; }  // because of the deadline
  // Errors estimated for the last query with the neo-Hookean law: of the displacements, and of the
  // nodal forces of contacts and supports.
  [[nodiscard]] const NodeVector& displacement_error() const { return x_; }
  [[nodiscard]] const NodeVector& reaction_error() const { return trial_; }
  // Error of a force that the residuals of the queries before leave in the path with friction,
  // relative to the force [-].
  [[nodiscard]] double PathError() const;
  // Counts of the last query: steps of Newton's method, iterations of their linear systems.
  [[nodiscard]] int newton_steps() const { return newton_steps_; }
  [[nodiscard]] int iterations() const { return iterations_; }
  [[nodiscard]] std::size_t memory_bytes() const {
    return tangent_.memory_bytes() + solver_.memory_bytes();
  }

 private:
  static constexpr int kFrictionSteps = 4;
  static constexpr int kMotions = 3;            // one per axis along which a contact moves
  static constexpr std::size_t kMaxPaths = 64;  // displacements of tools in one motion

  bool SolveInParts(const NodeVector& f_ext, const Constraints& constraints) noexcept;
  bool Iterate(const Constraints& constraints, double part) noexcept;
  bool Touch(const Constraints& constraints) noexcept;
  bool LetsGo(const Constraints& constraints) noexcept;
  void Predict(const Constraints& constraints) noexcept;
  void LearnMotion(const Constraints& constraints) noexcept;
  enum class Contacts { kFollow, kStay };
  enum class Correction { kMade, kContactsChange, kRefused };
  Correction Correct(const Constraints& constraints, Contacts contacts) noexcept;
  void LoadTools() noexcept;
  double FindGapsAndResidual(const Constraints& constraints) noexcept;
  [[nodiscard]] bool WithFriction() const;
  [[nodiscard]] double Requested() const;       // residual
  [[nodiscard]] double TargetResidual() const;  // at which Newton's method ends
  enum class With { kForces, kTangent };
  void Update(With with) noexcept;
  void PrepareTangent() noexcept;
  void Retreat(const NodeVector& to) noexcept;
  double FreeResidual(const Constraints& constraints) noexcept;
  bool Advance(const Constraints& constraints, bool lifted, double enough) noexcept;
  bool FindDirection(const Constraints& constraints, bool lifted, double enough) noexcept;
  SolveOutcome SolveWithFriction(const Constraints& constraints, double target) noexcept;
  void FollowFriction(const Constraints& constraints) noexcept;
  [[nodiscard]] double Potential() const noexcept;

  FemBody& body_;
  Params params_;
  bool hyperelastic_;
  SearchProgress progress_;
  BlockMatrix tangent_;
  LinearSolver solver_;
  bool is_current_ = false;     // forces and energy are those of u_
  bool has_tangent_ = false;    // the tangent is that of u_
  bool is_near_ = false;        // the tangent is that of u_ or of the step before
  bool keeps_tangent_ = false;  // one more step uses the tangent of an earlier u
  bool corrects_ = false;       // corrections follow this search
  bool settles_ = false;        // a correction has changed contacts, the tangent before it serves
  bool is_predicted_ = false;   // the step of the query is small
  NodeVector u_, last_u_, good_u_, f_ext_, last_f_, f_int_, r_, x_, lift_, trial_, reaction_,
      kept_u_, gap_force_, last_reaction_;
  NodeVector s_, left_, p_;  // change of friction in a step, what it lacks; scratch
  // A change of friction: the load, the motion that it causes, and the load less the friction that
  // this motion causes.
  struct FrictionStep {
    NodeVector load, x, change;
  };
  std::array<FrictionStep, kFrictionSteps> friction_steps_;
  // Motion of a query: of all nodes, and of the nodes that contacts prescribe.
  struct Motion {
    NodeVector body, contacts;
    std::array<Eigen::Vector3d, kMaxPaths> paths;  // displacement of each tool [m]
    int path_count = 0;
    double square = 0;            // squared norm of `contacts` before orthogonalization
    bool is_independent = false;  // not a combination of newer motions
  };
  void FindHeld(const Constraints& constraints, Motion* motion) const noexcept;
  std::array<Motion, kMotions> motions_;  // of the last queries, newest first
  int motion_count_ = 0;
  // Whether other nodes are constrained than when the motions were stored.
  bool has_new_constraints_ = false;
  ToolContacts* tools_ = nullptr;  // of the increment that is solved
  NodeVector f_base_;              // forces without the friction of the tools
  bool ended_early_ = false;
  ElementSummary summary_;
  double shift_ = 0;      // stiffness added to make a tangent definite
  double reference_ = 0;  // the loads' and reactions' norm
  double before_ = 0;     // norm of the reactions before the query
  double released_ = 0;   // replaces reference_ when there are no loads any more
  double relative_residual_ = 0;
  int newton_steps_ = 0, iterations_ = 0;
};

}  // namespace palpate::fem
