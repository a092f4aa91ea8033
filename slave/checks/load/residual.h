// One load explains the measured displacements: reduced chi-square of the residuals against their
// noise, with a share of the deflection for the error of the model.
#pragma once

#include "slave/checks/chi_square.h"
#include "slave/checks/load/fit_sample.h"
#include "slave/checks/load/load_limits.h"

namespace palpate {

class ResidualCheck final : public Check<FitSample> {
 public:
  // `noise`: residual that is accepted while that without contact is unknown [sigma].
  // `model_error`: by the largest deflection [-].
  ResidualCheck(double noise, double model_error) : noise_(noise), model_error_(model_error) {}

  void Examine(const FitSample& sample, Findings* findings) noexcept override {
    if (sample.left_out > LoadLimits::kMostLeftOut * sample.points) {
      findings->Fail(FailedCheck::kMisfit,
                     "more than a quarter of the points contradict the others");
    }
    const double rest = sample.rest_residual;
    // Without a load the residual is what that at rest is learnt from.
    const bool is_known = rest > 0 && sample.freedom > 0 && sample.load.force != 0;
    const double noise =
        is_known ? rest * rest * ChiSquareGate(sample.freedom) / sample.freedom : noise_ * noise_;
    const double model = sample.sigma > 0 ? model_error_ * sample.deepest / sample.sigma : 0;
    if (sample.load.residual * sample.load.residual <= noise + model * model) return;
    findings->Fail(FailedCheck::kMisfit,
                   "no load of this width explains the measured surface within its noise");
  }

 private:
  double noise_, model_error_;
};

}  // namespace palpate
