// Where drivers in any language feed tactile samples (FeedTactile): assembles the fingers' streams
// into frames at a steady rate.
#pragma once

#include <memory>
#include <optional>
#include <string>
#include <string_view>
#include <vector>

#include "slave/capture/finger_stream.h"
#include "slave/capture/tactile_frame.h"
#include "slave/scene/scene.h"

namespace palpate {

// Thread-safe. Bounded: what comes faster than it is taken replaces what is old.
class TactileInbox final : public TactileSource {
 public:
  // What a sample is refused for, in words that follow the finger's name.
  struct Refusal {
    std::string why;
  };
  // Tells senders apart. One who is alone needs none.
  using SenderId = FingerStream::SenderId;
  static constexpr SenderId kOnlySender = 0;

  explicit TactileInbox(const Tactile& tactile);
  ~TactileInbox() override;

  // One sample of one finger, taken at `sensed_at` of the sender's clock; `arrived_at` is the
  // slave's, from which the two clocks' offset is known: the smallest delay of the last seconds
  // counts as none. Refused: no such finger, counts that are not finite, a clock that goes back, a
  // sequence that does not rise (0: none is told), a pose that is no pose, another `sender` than
  // the one from whom this finger's samples came less than a second ago. A sample of the same time
  // as the one before is that sample again: taken, and dropped.
  std::optional<Refusal> Feed(std::string_view finger, std::uint64_t sequence, Time sensed_at,
                              const FingerReading& reading, Time arrived_at,
                              SenderId sender = kOnlySender);

  // `sender` has left `finger`, if it fed it: the next one's clock and sequence begin anew, after a
  // gap.
  void Leave(std::string_view finger, SenderId sender = kOnlySender);

  // Frames at the scene's rate as long as at least one finger sends; silence longer than three
  // periods is a gap. A finger that is silent for so long while others send is absent, and the
  // frame with which it returns comes after a gap. While the first finger that sends keeps the
  // scene's rate to a tenth, its samples are the frames as they are; whatever else is linear in
  // between.
  std::optional<TactileFrame> Next(const std::stop_token& stop) override;
  [[nodiscard]] std::string description() const override;

 private:
  struct State;
  std::unique_ptr<State> state_;
};

}  // namespace palpate
