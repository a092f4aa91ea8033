#include "slave/mechanics/bem/boundary_sum.h"

#include <cstddef>
#include <utility>

namespace palpate {

using Eigen::Vector2d;

BoundarySum::BoundarySum(const GreensFunctions& greens)
    : greens_(greens),
      answer_(static_cast<std::size_t>(greens.size()), Vector2d::Zero()),
      given_(answer_) {}

void BoundarySum::Add(int j, const Vector2d& value) {
  for (int i = 0; i < greens_.size(); ++i) {
    answer_[static_cast<std::size_t>(i)] +=
        Eigen::Map<const Eigen::Matrix2d>(greens_.block(i, j)) * value;
  }
  if (j < greens_.size()) given_[static_cast<std::size_t>(j)] += value;
}

void BoundarySum::Finish(std::vector<Vector2d>* displacement, std::vector<Vector2d>* traction) {
  displacement->assign(answer_.size(), Vector2d::Zero());
  *traction = std::move(given_);
  for (std::size_t i = 0; i < answer_.size(); ++i) {
    for (int c = 0; c < 2; ++c) {
      auto& known = greens_.held(static_cast<int>(i), c) ? *traction : *displacement;
      known[i][c] = answer_[i][c];
    }
  }
}

}  // namespace palpate
