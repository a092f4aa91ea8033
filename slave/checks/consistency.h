// Consistency tests all residuals of a sensing pipeline together: by a chi-square over a short
// window of samples.
#pragma once

#include <array>
#include <cstddef>
#include <string_view>

#include "shared/state/verdict.h"

namespace palpate {

// Difference of two independent values of one quantity. value / sigma is N(0, 1) if all is well.
struct Residual {
  FailedCheck code = FailedCheck::kNone;
  std::string_view reason;  // one clause with static lifetime
  double value = 0;
  double sigma = 1;  // > 0, same unit; of both values together
};

// Normalised innovation squared (NIS), summed per code over the last samples:
//
//   q = sum (value / sigma)^2 over n residuals   ~   chi-square with n degrees of freedom
//
// Source: Bar-Shalom, Li, Kirubarajan, Estimation with Applications to Tracking and
// Navigation, 5.4. Residuals must be independent from sample to sample: a constant offset belongs
// into the estimate, as a parameter. One thread; allocation-free.
class Consistency {
 public:
  static constexpr int kMaxCodes = 16;   // codes of one pipeline [-] [by definition]
  static constexpr int kMaxWindow = 16;  // [samples] [by definition]

  struct Result {
    Verdict verdict{Validity::kValid};
    // Factor >= 1 for the estimate's sigma: largest sqrt(q / n) of the codes that do not fail.
    double widening = 1;
  };

  // `window`: samples that are summed, 1 to kMaxWindow.
  explicit Consistency(int window = 10);

  // Adds a residual of the present sample. A residual that is not finite fails at once. A check
  // code may have several residuals.
  void Add(const Residual& residual) noexcept;
  // Ends the sample. A code fails if q exceeds the quantile 0.9999; of several codes the verdict
  // names the one that exceeds it most, with the reason of its largest residual in this sample.
  Result Close() noexcept;
  // Forgets all samples.
  void Reset() noexcept;

 private:
  struct Sum {
    double q = 0;
    int n = 0;
  };
  struct Window {
    FailedCheck code = FailedCheck::kNone;
    std::string_view reason;
    double largest = 0;  // square of the residual that gave `reason`
    std::array<Sum, kMaxWindow> sums{};
  };
  [[nodiscard]] Window* FindWindow(FailedCheck code) noexcept;
  [[nodiscard]] Sum Total(const Window& window) const noexcept;

  std::size_t window_;
  std::size_t now_ = 0;  // index of the present sample's sums
  std::size_t count_ = 0;
  std::array<Window, kMaxCodes> windows_;
};

}  // namespace palpate
