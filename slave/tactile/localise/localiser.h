// Localiser estimates where on the fingertip the contact is (paper B, III.A.2, equations 1 to 4).
#pragma once

#include <cstdint>
#include <memory>
#include <optional>
#include <span>
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
    kAtOrigin,   // equation 4 has no direction: the contact point is the origin
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

// The variant of `tactile.localise`, with its thresholds; `auto` is pressure-weighted, which has
// the smallest error. Throws std::invalid_argument: an unknown name, an electrode on the finger's
// axis.
std::unique_ptr<Localiser> MakeLocaliser(const Tactile& tactile, const ElectrodeLayout& layout);

// Makes a localiser for the channels of any sensor. It returns the mean position and normal of the
// channels that changed by more than `tactile.threshold` times `noise` in either direction,
// weighted by their change. Its sigma is unknown.
std::unique_ptr<Localiser> MakeChannelLocaliser(const Tactile& tactile, double noise,
                                                const ElectrodeLayout& layout);

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

// ContactPoint is computed from the active electrodes' intensities (paper B, equations 1 to 3).
// With the m active electrodes at p_i, intensities I_i:
//
//   x = sum p_i / m,   d_i = (p_i - x) I_i / sum I,   c = x + sum d_i / m
//
// The intensities are normalised already, so the last division by m pulls c towards the centroid x;
// paper and authors' code divide.
struct ContactPoint {
  Eigen::Vector3d centroid{0, 0, 0};  // x
  Eigen::Vector3d c{0, 0, 0};
};

// `p` of the active electrodes in any unit, `intensity` >= 0 of each. nullopt: none is active, or
// their intensities are all zero, or not finite. Allocation-free.
std::optional<ContactPoint> ContactPointOf(std::span<const Eigen::Vector3d> p,
                                           std::span<const double> intensity) noexcept;

}  // namespace palpate
