// Keys of the terminal as a device: E engages and disengages, the arrows and PgUp, PgDn move. A
// terminal reports no release of a key, so each key moves for a moment and repeats while held.
#pragma once

#include <array>
#include <memory>
#include <string>

#include <termios.h>

#include "master/device/rate/rate_device.h"
#include "master/device/search/driver.h"

namespace palpate {

// Meaning of the bytes that a terminal sends.
class KeyboardState {
 public:
  static constexpr double kKeyMoves = 0.060;  // after each byte sequence of a key [s]

  // Takes `size` bytes that came at `now`.
  void Take(const char* bytes, std::size_t size, Time now);
  [[nodiscard]] RateInput At(Time now) const;
  // Requests since the last call. Any key without another meaning is an emergency stop.
  [[nodiscard]] bool TakeStop();
  [[nodiscard]] bool TakeReset();

 private:
  void TakeMove(int axis, double sign, Time now);

  bool engaged_ = false, stop_ = false, reset_ = false;
  std::array<double, 3> sign_{};
  std::array<Time, 3> moved_at_{};
};

// Uses the standard input without echo and line buffer while it lives.
class KeyboardSource final : public RateSource {
 public:
  // Throws DeviceUnavailable where the standard input is no terminal.
  KeyboardSource();
  ~KeyboardSource() override;
  KeyboardSource(const KeyboardSource&) = delete;
  KeyboardSource& operator=(const KeyboardSource&) = delete;

  // Stop and reset leave as the signals SIGUSR1 and SIGUSR2, like those of any other sender.
  RateInput Poll(Time now) override;
  [[nodiscard]] std::string description() const override {
    return "keyboard: E engages, arrows and PgUp, PgDn move, R resets, any other key stops";
  }

 private:
  termios before_{};
  KeyboardState state_;
  bool gone_ = false;
};

// The row of the table of drivers.
Driver KeyboardDriver();

}  // namespace palpate
