// The width of an indentation at its depth fits the scene's prestress: it distinguishes tension at
// rest from stiffness.
#pragma once

#include <algorithm>
#include <cmath>

#include "slave/checks/load/fit_sample.h"
#include "slave/checks/points/noise_limits.h"

namespace palpate {

class TensionCheck final : public Check<FitSample> {
 public:
  // `prestress` of the scene [N/m].
  explicit TensionCheck(double prestress) : prestress_(prestress) {}

  // What one image leaves open many determine together.
  void Examine(const FitSample& sample, Findings* findings) noexcept override {
    const PlateFit& fit = *sample.plate;
    const LoadFitter::Sought& sought = fit.tension;
    if (!(sought.sigma > 0) || sample.load.force == 0) return;
    // Of the residuals that another tension leaves.
    const double freedom = std::max(1, fit.points - fit.left_out - 4);
    const double explained = sought.amount * sought.amount / (sought.sigma * sought.sigma);
    const double residual = fit.load.residual * fit.load.residual * (freedom + 1) - explained;
    const double scatter =
        std::sqrt(
            std::max(NoiseLimits::kLeastScatter * NoiseLimits::kLeastScatter, residual / freedom)) *
        sought.sigma;
    // Beyond the noise that the points have at rest, their errors go with the indentation's shape
    // and come again with it: those of compression, for example.
    const double again = scatter * std::sqrt(1 - sample.NoiseShare());
    const double weight = 1 / (scatter * scatter + fit.sigma_of_law * fit.sigma_of_law);
    auto& [information, score, law, sure, likely] = past_;
    information = kRemembered * information + weight;
    score = kRemembered * score + weight * sought.amount;
    law = kRemembered * law + weight * std::hypot(fit.sigma_of_law, again);
    const double amount = score / information;
    const double sigma = std::hypot(1 / std::sqrt(information), law / information);
    // What was sure once, at the depth that shows it best, stays so.
    sure = std::max(kRemembered * sure, std::abs(amount) - kSigmas * sigma);
    likely = std::max(kRemembered * likely, std::abs(amount) - 2 * sigma);
    const double wrong = std::max(kUncertain * likely, SigmaOfScene(amount, sigma));
    const double force = std::abs(sample.load.force), per_tension = std::abs(sought.force);
    findings->Widen(std::min(per_tension * wrong, force / 2));
    if (per_tension * sure > kShare * force) {
      findings->Fail(FailedCheck::kMisfit,
                     "the width of the indentation does not fit the scene's prestress");
    }
  }
  void Reset() noexcept override { past_ = {}; }

 private:
  // Of the evidence, from image to image [-]. [tuned: surface_doubts_test, dents of another
  // tension]
  static constexpr double kRemembered = 0.99;
  // At which another tension is certain [sigma]. [tuned: undisturbed, prestress told - there is
  // none]
  static constexpr double kSigmas = 3.5;
  // One sigma of a tension that is not certain, by its size: a likely one, and the scene's [-].
  // [recorded: 300 N/m in the scene of a loose membrane, 6 of 17 forces up to 2.4 times too large]
  static constexpr double kUncertain = 0.5;
  // Of the force, that a wrong tension may make [-]. [tuned: prestress told - there is none]
  static constexpr double kShare = 0.02;

  // By how much the tension may differ from the scene's, rms, where the scene names one, by what is
  // known beforehand and what the indentations show: `amount`, `sigma` [N/m]. A membrane without
  // prestress in the scene is loose.
  [[nodiscard]] double SigmaOfScene(double amount, double sigma) const noexcept {
    if (!(prestress_ > 0)) return 0;
    const double own = kUncertain * prestress_;
    const double known = 1 / (own * own), seen = 1 / (sigma * sigma);
    return std::hypot(seen * amount / (known + seen), 1 / std::sqrt(known + seen));
  }

  double prestress_;  // [N/m]
  // Least-squares estimate of the tension beyond the scene's, from the indentations of earlier
  // images.
  struct Past {
    double information = 0, score = 0, law = 0;
    double sure = 0, likely = 0;  // [N/m]
  } past_;
};

}  // namespace palpate
