// Where the force error comes from, at a site that knows the truth: what the model would say of the
// true indentation is the model's error, the rest is the eyes'.
#pragma once

#include <cmath>
#include <cstdint>
#include <vector>

#include <nlohmann/json_fwd.hpp>

namespace palpate {

// Root mean squares over pictures in contact.
class ErrorBudget {
 public:
  // Magnitudes of forces [N]: estimated; by the model at the true indentation; true.
  void Add(double estimated, double model_at_truth, double truth) {
    ++count_;
    total_ += Square(estimated - truth);
    model_ += Square(model_at_truth - truth);
    tracking_ += Square(estimated - model_at_truth);
    peak_ = std::fmax(peak_, truth);
    worst_ = std::fmax(worst_, std::abs(estimated - truth));
  }
  [[nodiscard]] std::uint64_t count() const { return count_; }
  [[nodiscard]] double rms() const { return Root(total_); }              // [N]
  [[nodiscard]] double model_rms() const { return Root(model_); }        // [N]
  [[nodiscard]] double tracking_rms() const { return Root(tracking_); }  // [N]
  [[nodiscard]] double peak_force() const { return peak_; }              // largest true force [N]
  [[nodiscard]] double peak_error() const { return worst_; }             // [N]

 private:
  static double Square(double x) { return x * x; }
  [[nodiscard]] double Root(double sum) const {
    return count_ == 0 ? 0 : std::sqrt(sum / static_cast<double>(count_));
  }

  std::uint64_t count_ = 0;
  double total_ = 0, model_ = 0, tracking_ = 0, peak_ = 0, worst_ = 0;
};

// Sizes of the forces of one picture at a site that knows the truth [N].
struct ComparedForces {
  double estimated = 0;  // NaN: unknown
  double model_at_truth = 0, truth = 0;
};

// Over pictures in contact, by the truth or by the estimate: those in which either exceeds 1 % of
// the peak. Unknown forces cannot be compared.
ErrorBudget BudgetOf(const std::vector<ComparedForces>& compared);
// null where no picture in contact was compared.
nlohmann::ordered_json ToJson(const ErrorBudget& budget);

}  // namespace palpate
