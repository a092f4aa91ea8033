// The contact point as the paper and its authors' code compute it.
#pragma once

#include <string_view>

#include "slave/tactile/localise/finger_surface.h"
#include "slave/tactile/localise/localiser.h"
#include "slave/tactile/localise/signal_check.h"

namespace palpate {

// Paper B, equations (1) to (4). Active are the electrodes that fell by more than the threshold;
// intensity is how far, over full scale, at most 1. Flawed also where all of several active
// electrodes are beyond full scale: their intensities tell nothing any more.
class PaperLocaliser final : public Localiser {
 public:
  PaperLocaliser(const Tactile& tactile, const ElectrodeLayout& layout);
  [[nodiscard]] TouchPlace Locate(const TactileSignals& change,
                                  const FingerReading& raw) const noexcept override;
  [[nodiscard]] std::string_view name() const override { return "paper"; }

 private:
  ElectrodeLayout layout_;
  FingerSurface surface_;
  SignalCheck check_;
  double threshold_, full_scale_;  // [counts]
};

}  // namespace palpate
