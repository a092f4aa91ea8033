// Localiser estimates where on the fingertip the contact is.
#pragma once

#include <cstdint>
#include <memory>
#include <string_view>

#include <Eigen/Core>

#include "slave/scene/scene.h"
#include "slave/tactile/localise/electrode_layout.h"
#include "slave/tactile/signals/tactile_signals.h"

namespace palpate {

struct TouchPlace {
  enum class Status : std::uint8_t {
    kFound,
    kNoContact,  // no electrode is active
    kAtOrigin,   // the directions of the active electrodes cancel
    kFlawed,     // found, but electrodes are saturated or dead: less exact than usual
    kFailed,     // signals that are not finite
  };
  Status status = Status::kNoContact;
  Eigen::Vector3d p_F{0, 0, 0};  // on the fingertip's surface [m]
  Eigen::Vector3d n_F{0, 0, 0};  // outward unit normal at the contact point
  double sigma = 0;              // one sigma of the contact point along the surface [m]; 0: unknown
  int active = 0;                // electrodes used
  // Some electrodes are saturated or dead, which may be the reason if no contact is found.
  bool is_flawed = false;
  [[nodiscard]] bool usable() const {
    return status == Status::kFound || status == Status::kFlawed;
  }
};

// Immutable; thread-safe.
class Localiser {
 public:
  virtual ~Localiser() = default;
  Localiser() = default;
  Localiser(const Localiser&) = delete;
  Localiser& operator=(const Localiser&) = delete;
  // `change`: counts minus baseline; `raw`: counts, to detect saturated or dead electrodes.
  // Allocation-free.
  [[nodiscard]] virtual TouchPlace Locate(const TactileSignals& change,
                                          const FingerReading& raw) const noexcept = 0;
  // Returns the name, for example `pressure-weighted`.
  [[nodiscard]] virtual std::string_view name() const = 0;
};

// The localiser of a fingertip with 19 electrodes (direction_mean.h). Throws std::invalid_argument:
// an electrode on the finger's axis.
std::unique_ptr<Localiser> MakeLocaliser(const Tactile& tactile, const ElectrodeLayout& layout);

// Makes a localiser for the channels of any sensor. It returns the mean position and normal of the
// channels that changed by more than five times `noise`, their noise at rest, in either direction,
// weighted by their change. Its sigma is unknown.
std::unique_ptr<Localiser> MakeChannelLocaliser(double noise, const ElectrodeLayout& layout);

// Shared output of the localisers.
inline TouchPlace NoPlace(TouchPlace::Status status, bool is_flawed = false) noexcept {
  return {.status = status, .is_flawed = is_flawed};
}

// Without one electrode the median error is up to 1.6 times that with all (measured by leaving out
// each of them in turn). [-] [tuned: OneDeadElectrodeAddsNoMoreThanSigmaSays]
inline constexpr double kFlawedSigma = 1.6;

// Contact point `p_F` on the surface; `sigma_angle` [rad]: its sigma about the sphere's centre or
// the axis.
inline TouchPlace FoundPlace(const FingerSurface& surface, const Eigen::Vector3d& p_F,
                             double sigma_angle, bool is_flawed, int active) noexcept {
  return {.status = is_flawed ? TouchPlace::Status::kFlawed : TouchPlace::Status::kFound,
          .p_F = p_F,
          .n_F = surface.Normal(p_F),
          .sigma = surface.radius * sigma_angle * (is_flawed ? kFlawedSigma : 1),
          .active = active,
          .is_flawed = is_flawed};
}

}  // namespace palpate
