// Relaxation of forces by a series of exponentials (Prony), in time steps.
//
//   F(t) = integral of g(t - s) dF_e/ds ds,   g(t) = 1 - sum of share_i (1 - exp(-t / time_i))
//
// F_e: force of the elastic body with its instantaneous moduli, zero before the first step. Exact
// if F_e is linear within the steps: every term stores
//
//   q_i <- exp(-h) q_i + share_i (1 - exp(-h)) / h dF_e,   h = step / time_i
//
// and F = (1 - sum of share_i) F_e + sum of q_i. If all moduli of a linear body relax alike, these
// are its forces under prescribed displacements for any shape (correspondence principle:
// Christensen, Theory of Viscoelasticity, 1982, 2.2). With F_e of a nonlinear body the law is
// quasi-linear (Fung, Biomechanics, 1993, 7.6). Immutable; O(terms).
#pragma once

#include <array>
#include <cmath>
#include <cstddef>
#include <span>
#include <vector>

#include <Eigen/Core>

#include "slave/scene/options/object.h"

namespace palpate {

// Shares of a term with this relaxation time after a step: of its former value, and of an increment
// that is added evenly during the step.
struct PronyStep {
  double fade = 1, rise = 1;

  PronyStep(double step, double time) {
    const double h = step / time;
    fade = std::exp(-h);
    if (h > 1e-9) rise = -std::expm1(-h) / h;
  }
};

// A force and its moment.
using Wrench = Eigen::Matrix<double, 6, 1>;

// Relaxation state of one contact.
struct RelaxationMemory {
  Wrench elastic = Wrench::Zero();  // F_e at the end of the last step
  std::array<Wrench, Material::kMaxRelaxationTerms> terms{};

  RelaxationMemory() { terms.fill(Wrench::Zero()); }
};

class PronySeries {
 public:
  // At most kMaxRelaxationTerms. Throws std::invalid_argument: shares not > 0 or with a sum of 1
  // or more, times or step not > 0.
  PronySeries(std::span<const RelaxationTerm> terms, double step);

  // F at the end of the next step, at which F_e is `elastic`.
  Wrench Advance(const Wrench& elastic, RelaxationMemory* memory) const;
  // Advances a force whose moment is unknown: the moment stays as it is.
  Eigen::Vector3d Advance(const Eigen::Vector3d& elastic, RelaxationMemory* memory) const;
  // F right after F_e jumps to `elastic`.
  Wrench Jump(const Wrench& elastic, RelaxationMemory* memory) const;
  // F_e for which F at the end of the next step is `force`.
  [[nodiscard]] Wrench ElasticFor(const Wrench& force, const RelaxationMemory& memory) const;
  // dF / dF_e of the next step [-].
  [[nodiscard]] double at_once() const { return at_once_; }

 private:
  template <int kRows>
  void AdvanceRows(const Wrench& elastic, RelaxationMemory* memory, Wrench* force) const;
  // F of a next step without change of F_e.
  [[nodiscard]] Wrench Kept(const RelaxationMemory& memory) const;

  struct Step {
    double fade = 1, taken = 0;  // factors of the stored term and of the added force [-]
  };

  std::vector<RelaxationTerm> terms_;
  std::vector<Step> steps_;
  double left_ = 1;     // fraction of the force after all terms have decayed
  double at_once_ = 1;  // left_ plus the shares of the terms
};

}  // namespace palpate
