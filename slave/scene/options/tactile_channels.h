// Channels in one sample of a tactile sensor.
#pragma once

#include <string>

namespace palpate {

inline constexpr int kElectrodeCount = 19;
inline constexpr int kMaxChannels = 256;

// Number and unit of a sensor's channels: taxels, magnetometers, pressure cells. The default is the
// electrodes of a fingertip, which also sends two pressures.
struct TactileChannels {
  int count = kElectrodeCount;
  std::string unit = "counts";

  bool operator==(const TactileChannels&) const = default;
  [[nodiscard]] bool are_electrodes() const { return *this == TactileChannels{}; }
  // `E1` or `c1` for 0.
  [[nodiscard]] std::string NameOf(int channel) const {
    return (are_electrodes() ? "E" : "c") + std::to_string(channel + 1);
  }
  [[nodiscard]] std::string Names() const { return NameOf(0) + " to " + NameOf(count - 1); }
};

}  // namespace palpate
