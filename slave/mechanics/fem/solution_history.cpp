#include "slave/mechanics/fem/solution_history.h"

#include <algorithm>
#include <cmath>
#include <cstddef>

namespace palpate::fem {
namespace {

constexpr double kIndependent = 1e-8;  // of a direction's square, after what it shares is removed

}  // namespace

SolutionHistory::SolutionHistory(int nodes) : change_(static_cast<std::size_t>(nodes)) {
  for (auto* set : {&differences_, &directions_, &products_}) {
    for (auto& x : *set) x.resize(static_cast<std::size_t>(nodes));
  }
}

void SolutionHistory::Keep(const NodeVector& solution) noexcept {
  change_ = solution;
  known_ = std::min(known_ + 1, kDepth);
  for (auto& difference : differences_) {
    std::swap(difference, change_);  // now change_ is the older one of this order
    for (std::size_t i = 0; i < change_.size(); ++i) {
      for (std::size_t c = 0; c < 3; ++c) change_[i].v[c] = difference[i].v[c] - change_[i].v[c];
    }
  }
}

void SolutionHistory::Improve(const BlockMatrix& A, const Constraints& constraints, NodeVector& r,
                              NodeVector& x) noexcept {
  int kept = 0;
  for (int k = 0; k < known_; ++k) {
    NodeVector& d = directions_[static_cast<std::size_t>(kept)];
    NodeVector& product = products_[static_cast<std::size_t>(kept)];
    d = differences_[static_cast<std::size_t>(k)];
    constraints.ProjectMotion(d);
    A.Multiply(d, product);
    constraints.ProjectForce(product);
    const double before = Dot(d, product);
    for (int l = 0; l < kept; ++l) {
      const auto at = static_cast<std::size_t>(l);
      const double share = Dot(directions_[at], product) / Dot(directions_[at], products_[at]);
      Add(-share, directions_[at], d);
      Add(-share, products_[at], product);
    }
    const double square = Dot(d, product);
    if (!(square > kIndependent * before)) continue;
    const double amount = Dot(d, r) / square;
    Add(amount, d, x);
    Add(-amount, product, r);
    ++kept;
  }
}

}  // namespace palpate::fem
