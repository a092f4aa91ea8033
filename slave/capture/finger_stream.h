// The samples of one live fingertip, on the slave's clock, a bounded number of them.
#pragma once

#include <cstddef>
#include <cstdint>
#include <optional>
#include <string>
#include <vector>

#include "slave/capture/sender_clock.h"
#include "slave/capture/tactile_frame.h"

namespace palpate {

// Not thread-safe. What runs per sample allocates nothing.
class FingerStream {
 public:
  struct Sample {
    Time at{};            // slave's clock
    bool begins = false;  // a stretch: nothing is known between this sample and the one before
    FingerReading reading;
  };

  // `period`: of the scene's rate.
  FingerStream(std::string name, Clock::duration period, std::size_t capacity);

  [[nodiscard]] const std::string& name() const { return name_; }
  using SenderId = std::uint64_t;

  // nullopt: taken. Else why not, in words that follow the finger's name. A sender who has been
  // silent for a second gives way to another.
  std::optional<std::string> Take(std::uint64_t sequence, Time sensed_at,
                                  const FingerReading& reading, Time arrived_at, SenderId sender);
  // If it is its sender: the next one begins anew.
  void Leave(SenderId sender) noexcept;

  // Whether samples come, as far as is known at `now`, the newest time of any finger.
  [[nodiscard]] bool IsSending(Time now) const noexcept;
  // Whether the sender keeps the scene's rate to a tenth.
  [[nodiscard]] bool KeepsRate() const noexcept;
  // Null: none yet.
  [[nodiscard]] const Sample* newest() const noexcept;
  // The first sample later than `t`; null: none yet.
  [[nodiscard]] const Sample* After(Time t) const noexcept;
  // What it read at `t`, linear between samples; absent before the first, after the newest and
  // inside a gap.
  [[nodiscard]] FingerReading At(Time t) const noexcept;
  // Drops what no instant after `t` needs.
  void Forget(Time t) noexcept;

 private:
  [[nodiscard]] Clock::duration patience() const noexcept;
  [[nodiscard]] const Sample& Get(std::size_t i) const noexcept {
    return ring_[(first_ + i) % ring_.size()];
  }
  void BeginAnew() noexcept;
  void Push(const Sample& sample) noexcept;
  void DropFirst() noexcept;

  std::string name_;
  double period_;         // of the scene [s]
  double sender_period_;  // of the sender, smoothed [s]
  SenderClock clock_;
  SenderId sender_ = 0;            // of the newest sample
  Time heard_at_{};                // when it arrived
  std::uint64_t sequence_ = 0;     // of the newest sample
  std::optional<Time> sensed_at_;  // of the newest sample, sender's clock; nullopt: a new sender
  std::vector<Sample> ring_;       // times rise
  std::size_t first_ = 0, count_ = 0;
};

}  // namespace palpate
