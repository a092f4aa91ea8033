// TactileInbox receives tactile samples that drivers in any language feed (FeedTactile). It
// assembles the fingers' streams into frames at a steady rate.
#pragma once

#include <cstddef>
#include <cstdint>
#include <memory>
#include <optional>
#include <string>
#include <string_view>
#include <vector>

#include "shared/state/clock.h"
#include "slave/capture/sender_clock.h"
#include "slave/capture/tactile_frame.h"
#include "slave/scene/scene.h"

namespace palpate {

// The samples of one live fingertip, on the slave's clock, a bounded number of them. Not
// thread-safe. Work per sample is allocation-free.
class FingerStream {
 public:
  struct Sample {
    Time at{};            // slave's clock
    bool begins = false;  // there is a gap before this sample, so nothing is interpolated there
    FingerReading reading;
  };

  // `period`: of the scene's rate.
  FingerStream(std::string name, TactileChannels channels, Clock::duration period,
               std::size_t capacity);

  [[nodiscard]] const std::string& name() const { return name_; }
  [[nodiscard]] const std::string& unit() const { return channels_.unit; }
  using SenderId = std::uint64_t;

  // nullopt: accepted. Otherwise the reason of the rejection, which continues the finger's name.
  // Another sender is accepted after a silence: of one second if the present sender has sent twenty
  // samples without a gap, else of ten periods.
  std::optional<std::string> Take(std::uint64_t sequence, Time sensed_at,
                                  const FingerReading& reading, Time arrived_at, SenderId sender);
  // Ends the feed if it is the present sender: the next one may start again.
  void Leave(SenderId sender) noexcept;

  // Returns whether samples arrive, at `now`, the newest time of any finger.
  [[nodiscard]] bool IsSending(Time now) const noexcept;
  // Returns whether the sender's rate is within a tenth of the scene's.
  [[nodiscard]] bool KeepsRate() const noexcept;
  // Null: none yet.
  [[nodiscard]] const Sample* newest() const noexcept;
  // The first sample later than `t`; null: none yet.
  [[nodiscard]] const Sample* After(Time t) const noexcept;
  // The reading at `t`, linear between samples; absent before the first, after the newest and
  // inside a gap.
  [[nodiscard]] FingerReading At(Time t) const noexcept;
  // Drops samples that are not needed after `t`.
  void Forget(Time t) noexcept;

 private:
  [[nodiscard]] std::optional<std::string> RefuseOrder(std::uint64_t sequence,
                                                       Time sensed_at) const;
  [[nodiscard]] Clock::duration SilenceAllowed() const noexcept;
  [[nodiscard]] Clock::duration max_silence() const noexcept;
  [[nodiscard]] const Sample& Get(std::size_t i) const noexcept {
    return ring_[(first_ + i) % ring_.size()];
  }
  void Restart() noexcept;
  void Push(const Sample& sample) noexcept;
  void DropFirst() noexcept;

  std::string name_;
  TactileChannels channels_;
  double period_;         // of the scene [s]
  double sender_period_;  // of the sender, smoothed [s]
  SenderClock clock_;
  SenderId sender_ = 0;            // of the newest sample
  Time arrived_at_{};              // of the newest sample
  int run_ = 0;                    // samples since the last gap, counted up to a driver's
  std::uint64_t sequence_ = 0;     // of the newest sample
  std::optional<Time> sensed_at_;  // of the newest sample, sender's clock; nullopt: a new sender
  std::vector<Sample> ring_;       // times rise
  std::size_t first_ = 0, count_ = 0;
};

// Thread-safe. Bounded: if samples arrive faster than they are read, new ones replace old ones.
class TactileInbox final : public TactileSource {
 public:
  // Reason for rejecting a sample; it continues the finger's name.
  struct Refusal {
    std::string why;
  };
  // Identifies senders. A single sender needs none.
  using SenderId = FingerStream::SenderId;
  static constexpr SenderId kOnlySender = 0;

  explicit TactileInbox(const Tactile& tactile);
  ~TactileInbox() override;

  // Takes one sample of one finger, in `unit` (empty: not stated), taken at `sensed_at` of the
  // sender's clock; `arrived_at` is the slave's clock. The offset of the clocks follows from the
  // smallest delay of the last seconds, which counts as zero. Rejects: unknown finger, another
  // number or unit of channels, values that are not finite, a time that decreases, a sequence that
  // does not rise (0: not used), an invalid pose, another `sender` than the one that sent this
  // finger's samples within the last second. A sample with the time of the previous one is a
  // repetition: accepted, and dropped.
  std::optional<Refusal> Feed(std::string_view finger, std::uint64_t sequence, Time sensed_at,
                              const FingerReading& reading, Time arrived_at,
                              SenderId sender = kOnlySender, std::string_view unit = {});

  // `sender` has left `finger`. If it was its sender, clock and sequence of the next one may start
  // again, after a gap.
  void Leave(std::string_view finger, SenderId sender = kOnlySender);

  // Frames at the scene's rate as long as at least one finger sends; silence longer than three
  // periods is a gap. A finger that is silent for so long while others send is absent, and its
  // first frame afterwards follows a gap. While the first sending finger keeps the scene's rate
  // within a tenth, its samples define the frames; the others are interpolated linearly.
  // nullopt also where none is complete with a driven clock.
  std::optional<TactileFrame> Next(const std::stop_token& stop) override;
  [[nodiscard]] std::string description() const override;

 private:
  struct State;
  std::unique_ptr<State> state_;
};

}  // namespace palpate
