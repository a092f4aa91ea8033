// A contact's direction from a sample: valid electrodes, the intensity of each, and the mean of
// their directions.
#pragma once

#include <array>
#include <cstddef>
#include <optional>

#include <Eigen/Core>

#include "slave/tactile/localise/electrode_layout.h"
#include "slave/tactile/signals/tactile_signals.h"

namespace palpate {

// SignalFlaws states whether a sample has values that are not finite, saturated or dead electrodes.
struct SignalFlaws {
  bool finite = true;      // false: no direction
  bool saturated = false;  // an electrode reads the end of its 12 bits
  std::array<bool, kElectrodeCount> dead{};
  bool any_dead = false;
  [[nodiscard]] bool any() const { return saturated || any_dead; }
};

class SignalCheck {
 public:
  explicit SignalCheck(const ElectrodeLayout& layout);

  // An electrode counts as dead if it reads exactly its baseline while the two nearest to it have
  // moved by 20 counts and most others at all. If readings and baseline are whole counts, an
  // electrode that passes its baseline looks the same for a sample: 2 % of the samples of contacts
  // on a plate. Allocation-free.
  [[nodiscard]] SignalFlaws Check(const TactileSignals& change,
                                  const FingerReading& raw) const noexcept;

 private:
  std::array<std::array<int, 2>, kElectrodeCount> nearest_{};
};

// A contact raises the fluid's pressure, and the electrodes that are not under it rise in
// proportion. So a change is measured relative to the change that the pressure explains,
//
//   x_i = change_i - kPressureShare change_pdc,
//
// so that even a soft contact, under which hardly any electrode falls, shows where they rise least.
// The share is between the best for presses on a plate (0.10) and for others of that sensor (0.15);
// on the authors' soft recording, another sensor, the electrodes' mean is 0.17. [counts / count].
// [tuned: ErrsLessThanThePaper]
inline constexpr double kPressureShare = 0.13;

// Change of an active electrode. [counts]
inline constexpr double kActiveCounts = 5;

struct Intensities {
  std::array<double, kElectrodeCount> of{};  // 0: not active
  double total = 0;
  int active = 0;

  void Set(std::size_t electrode, double intensity) noexcept {
    of[electrode] = intensity;
    total += intensity;
    ++active;
  }
};

// Active: x_i < -kActiveCounts; intensity |x_i| [counts]. Dead electrodes are not used.
Intensities PressureWeighted(const TactileSignals& change, const SignalFlaws& flaws) noexcept;

// A contact from intensities by averaging directions: an improved form of equations (1) to (4) of
// paper B, III.A.2. Every electrode is first projected on the finger's surface (equation 4). Its
// outward normal there is averaged, weighted by intensity:
//
//   n = sum I_i n_i / |sum I_i n_i|
//
// The paper averages positions inside the core and projects their mean. Then distant electrodes
// shift the mean backwards by their whole distance, although they contain no more information on
// the direction than near ones.
struct ContactDirection {
  Eigen::Vector3d n_F{0, 0, 0};  // unit
  double axis_x = 0;             // axial position as the mean weighted by the intensities [m], <= 0
};

class DirectionMean {
 public:
  // Throws std::invalid_argument: an electrode without a direction.
  DirectionMean(const ElectrodeLayout& layout, double radius);

  // nullopt: no intensity, or directions that cancel.
  [[nodiscard]] std::optional<ContactDirection> Mean(const Intensities& intensities) const noexcept;

  // The surface point with this outward normal. The sphere at the tip has one for every elevation
  // above the plane x = 0; the cylinder has the same normal along its length, so there the mean
  // along the axis decides. Between elevation 0 and kBlend both are blended.
  [[nodiscard]] Eigen::Vector3d PlaceOf(const ContactDirection& direction) const noexcept;

  [[nodiscard]] const FingerSurface& surface() const noexcept { return surface_; }

 private:
  FingerSurface surface_;
  std::array<Eigen::Vector3d, kElectrodeCount> n_F_;
  std::array<double, kElectrodeCount> axis_x_{};
};

}  // namespace palpate
