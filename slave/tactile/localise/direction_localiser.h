// The contact as the mean of the active electrodes' directions.
#pragma once

#include <cstdint>
#include <string_view>

#include "slave/tactile/localise/direction_mean.h"
#include "slave/tactile/localise/localiser.h"
#include "slave/tactile/localise/signal_check.h"

namespace palpate {

// Formulas of ours: DirectionMean with the intensities of PressureWeighted or PolarityFree.
class DirectionLocaliser final : public Localiser {
 public:
  enum class Weighting : std::uint8_t { kPressureWeighted, kPolarityFree };
  // Throws std::invalid_argument: an electrode on the finger's axis.
  DirectionLocaliser(const Tactile& tactile, const ElectrodeLayout& layout, Weighting weighting);
  [[nodiscard]] TouchPlace Locate(const TactileSignals& change,
                                  const FingerReading& raw) const noexcept override;
  [[nodiscard]] std::string_view name() const override;

 private:
  DirectionMean mean_;
  SignalCheck check_;
  Weighting weighting_;
  double threshold_, full_scale_;  // [counts]
};

}  // namespace palpate
