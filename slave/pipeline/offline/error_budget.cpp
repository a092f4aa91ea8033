#include "slave/pipeline/offline/error_budget.h"

#include <nlohmann/json.hpp>

namespace palpate {

ErrorBudget BudgetOf(const std::vector<ComparedForces>& compared) {
  constexpr double kContactShare = 0.01;
  ErrorBudget budget;
  double peak = 0;
  for (const ComparedForces& c : compared) peak = std::fmax(peak, c.truth);
  for (const ComparedForces& c : compared) {
    const bool contact = c.truth > kContactShare * peak || c.estimated > kContactShare * peak;
    if (contact && std::isfinite(c.estimated)) budget.Add(c.estimated, c.model_at_truth, c.truth);
  }
  return budget;
}

nlohmann::ordered_json ToJson(const ErrorBudget& budget) {
  if (budget.count() == 0) return nullptr;
  return {{"rms_N", budget.rms()},
          {"peak_N", budget.peak_error()},
          {"contact_frames", budget.count()},
          {"true_peak_N", budget.peak_force()},
          {"model_rms_N", budget.model_rms()},
          {"tracking_rms_N", budget.tracking_rms()}};
}

}  // namespace palpate
