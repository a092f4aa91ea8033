// The width of an indentation at its depth fits the scene's prestress: it distinguishes tension at
// rest from stiffness.
#pragma once

#include "slave/checks/load/fit_sample.h"

namespace palpate {

class TensionCheck final : public Check<FitSample> {
 public:
  // `prestress` of the scene [N/m].
  explicit TensionCheck(double prestress) : prestress_(prestress) {}

  // What one image leaves open many determine together.
  void Examine(const FitSample& sample, Findings* findings) noexcept override;
  void Reset() noexcept override { past_ = {}; }

 private:
  [[nodiscard]] double SigmaOfScene(double amount, double sigma) const noexcept;

  double prestress_;  // [N/m]
  // Least-squares estimate of the tension beyond the scene's, from the indentations of earlier
  // images.
  struct Past {
    double information = 0, score = 0, law = 0;
    double sure = 0, likely = 0;  // [N/m]
  } past_;
};

}  // namespace palpate
