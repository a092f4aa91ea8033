#include "slave/pipeline/press/stiffness_fit.h"

#include <cmath>
#include <stdexcept>
#include <string>

namespace palpate {

StiffnessFit FitStiffness(std::span<const KnownPress> presses, bool with_offset) {
  const std::size_t unknowns = with_offset ? 2 : 1;
  if (presses.size() <= unknowns) {
    throw std::invalid_argument(std::to_string(presses.size()) +
                                " presses of known force: accepted is at least " +
                                std::to_string(unknowns + 1));
  }
  const auto count = static_cast<double>(presses.size());
  double mean_own = 0;
  double mean_force = 0;
  for (const KnownPress& press : presses) {
    if (!with_offset) break;
    mean_own += press.own_force / count;
    mean_force += (press.force - press.air_force) / count;
  }
  double own_own = 0;
  double own_force = 0;
  double total = 0;
  for (const KnownPress& press : presses) {
    const double own = press.own_force - mean_own;
    own_own += own * own;
    own_force += own * (press.force - press.air_force - mean_force);
    total += press.own_force * press.own_force;
  }
  if (!(own_own > 1e-12 * total && std::isfinite(own_force))) {
    throw std::invalid_argument("presses of known force: accepted are different ones");
  }
  StiffnessFit fit;
  fit.stiffness = own_force / own_own;
  fit.offset = mean_force - fit.stiffness * mean_own;
  double squares = 0;
  for (const KnownPress& press : presses) {
    const double off = press.force - fit.stiffness * press.own_force - press.air_force - fit.offset;
    squares += off * off;
  }
  fit.scatter = std::sqrt(squares / count);
  fit.sigma_stiffness = std::sqrt(squares / (count - static_cast<double>(unknowns)) / own_own);
  return fit;
}

}  // namespace palpate
