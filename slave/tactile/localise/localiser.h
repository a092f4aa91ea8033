// Where on the fingertip the contact is (paper B, III.A.2, equations 1 to 4).
#pragma once

#include <cstdint>
#include <memory>
#include <string>
#include <string_view>

#include <Eigen/Core>

#include "slave/scene/scene.h"
#include "slave/tactile/localise/electrode_layout.h"
#include "slave/tactile/rest_values.h"

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
  Eigen::Vector3d n_F{0, 0, 0};  // its outward unit normal there
  double sigma = 0;              // one sigma of the place along the surface [m]; 0: not known
  int active = 0;                // electrodes used
  // Electrodes are saturated or dead. Where nothing is found, that may be why.
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
  // `change`: counts minus rest; `raw`: as read, for what is saturated or dead. Allocation-free.
  [[nodiscard]] virtual TouchPlace Locate(const TactileSignals& change,
                                          const FingerReading& raw) const noexcept = 0;
  // `polarity-free`, say.
  [[nodiscard]] virtual std::string_view name() const = 0;
};

// The variant that `tactile.localise` names, with its thresholds; `auto` is the best of the formula
// variants, pressure-weighted. A fitted file brings its own layout and threshold. Throws
// std::runtime_error: a fitted file that cannot be used, std::invalid_argument: an unknown name, an
// electrode on the finger's axis.
std::unique_ptr<Localiser> MakeLocaliser(const Tactile& tactile, const ElectrodeLayout& layout);

}  // namespace palpate
