// Readings of all fingertips of a scene at one instant, and their source.
#pragma once

#include <array>
#include <cstdint>
#include <optional>
#include <stop_token>
#include <string>

#include <Eigen/Geometry>

#include "shared/state/clock.h"
#include "shared/state/slave_state.h"
#include "slave/capture/short_list.h"
#include "slave/scene/options/tactile_channels.h"

namespace palpate {

using ChannelValues = ShortList<float, kMaxChannels, kElectrodeCount>;

// Raw values of one fingertip, the baseline not subtracted.
struct FingerReading {
  bool present = false;                   // false: this finger has no sample for this instant
  ChannelValues channels;                 // E1 to E19, or c1 to cN [TactileChannels::unit]
  float pac = 0;                          // dynamic pressure, pac0; 0 where the sensor has none
  float pdc = 0;                          // static pressure; 0 where the sensor has none
  std::optional<Eigen::Isometry3d> X_SF;  // pose of the fingertip, if the source provides it
};

// Largest value of a channel that is accepted [counts, or its unit]: no sensor sends more.
inline constexpr double kMaxCounts = 1e9;
// Longest time between two samples that is no gap [periods].
inline constexpr double kMaxPause = 3;

struct TactileFrame {
  std::uint64_t sequence = 0;  // from 1
  Time sensed_at{};
  bool after_gap = false;  // samples are missing just before this one: windows start again
  std::array<FingerReading, kMaxFingers> fingers{};  // in the scene's order
};

class TactileSource {
 public:
  virtual ~TactileSource() = default;
  TactileSource() = default;
  TactileSource(const TactileSource&) = delete;
  TactileSource& operator=(const TactileSource&) = delete;
  // The next instant, at the scene's rate; blocks until there is one. nullopt: the source has ended
  // or `stop` was requested. Throws std::runtime_error where a source breaks; the message names it.
  virtual std::optional<TactileFrame> Next(const std::stop_token& stop) = 0;
  // Returns the description for people.
  [[nodiscard]] virtual std::string description() const = 0;
};

}  // namespace palpate
