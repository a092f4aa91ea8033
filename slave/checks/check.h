// A check compares one sample with independent information: another sensor, the baseline, or the
// model. It returns a verdict and an additional uncertainty of the force.
#pragma once

#include <cmath>
#include <memory>
#include <string_view>
#include <utility>
#include <vector>

#include "shared/state/verdict.h"

namespace palpate {

// Findings collects the results of the checks of one sample.
struct Findings {
  Verdict verdict{Validity::kValid};
  double sigma_force = 0;  // independent of the sigma of the estimate [N]
  double widening = 1;     // factor of the sigma of the estimate, >= 1 [-]

  void Fail(FailedCheck check, std::string_view reason) noexcept { verdict.Fail(check, reason); }
  void Widen(double sigma) noexcept { sigma_force = std::hypot(sigma_force, sigma); }
};

// `Sample`: the observation and the answer of the model, of one kind of sensing.
template <class Sample>
class Check {
 public:
  Check() = default;
  Check(const Check&) = delete;
  Check& operator=(const Check&) = delete;
  virtual ~Check() = default;

  // Call it once per sample. Allocation-free after the first samples.
  virtual void Examine(const Sample& sample, Findings* findings) noexcept = 0;
  // Called when nothing is in contact and the object may have moved.
  virtual void Reset() noexcept {}
};

// The checks of one sensing pipeline, in the order of their calls.
template <class Sample>
class Checks {
 public:
  void Add(std::unique_ptr<Check<Sample>> check) { checks_.push_back(std::move(check)); }
  [[nodiscard]] Findings Examine(const Sample& sample) noexcept {
    Findings findings;
    for (const auto& check : checks_) check->Examine(sample, &findings);
    return findings;
  }
  void Reset() noexcept {
    for (const auto& check : checks_) check->Reset();
  }

 private:
  std::vector<std::unique_ptr<Check<Sample>>> checks_;
};

}  // namespace palpate
