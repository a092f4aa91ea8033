#include "slave/pipeline/offline/error_budget.h"

#include <algorithm>
#include <cmath>

#include <nlohmann/json.hpp>

namespace palpate {
namespace {

constexpr double kContactShare = 0.01;  // of the true peak

// Root mean square of what was added.
class Rms {
 public:
  void Add(double x) {
    sum_ += x * x;
    ++count_;
  }
  [[nodiscard]] double value() const {
    return count_ > 0 ? std::sqrt(sum_ / static_cast<double>(count_)) : 0;
  }

 private:
  double sum_ = 0;
  std::uint64_t count_ = 0;
};

}  // namespace

ErrorBudget BudgetOf(const std::vector<ComparedForces>& compared) {
  ErrorBudget budget;
  for (const ComparedForces& c : compared) {
    budget.peak_force = std::fmax(budget.peak_force, c.truth.norm());
  }
  Rms total, model, tracking;
  for (const ComparedForces& c : compared) {
    const double estimated = c.estimated.norm(), truth = c.truth.norm();
    const bool touches = std::fmax(estimated, truth) > kContactShare * budget.peak_force;
    if (!touches || !std::isfinite(estimated)) continue;
    const double error = (c.estimated - c.truth).norm();
    ++budget.count;
    total.Add(error);
    budget.peak_error = std::fmax(budget.peak_error, error);
    if (!std::isfinite(c.model_at_truth)) continue;
    model.Add(c.model_at_truth - truth);
    tracking.Add(estimated - c.model_at_truth);
  }
  budget.rms = total.value();
  budget.model_rms = model.value();
  budget.tracking_rms = tracking.value();
  return budget;
}

nlohmann::ordered_json ToJson(const ErrorBudget& budget, const std::string& samples) {
  if (budget.count == 0) return nullptr;
  return {{"rms_N", budget.rms},
          {"peak_N", budget.peak_error},
          {"contact_" + samples, budget.count},
          {"true_peak_N", budget.peak_force},
          {"model_rms_N", budget.model_rms},
          {"tracking_rms_N", budget.tracking_rms}};
}

}  // namespace palpate
