#include "slave/capture/tactile_inbox.h"

#include <array>
#include <cmath>
#include <mutex>
#include <utility>

#include "shared/link/priority_inheritance_mutex.h"
#include "shared/state/driven_clock.h"
#include "shared/text/text.h"

namespace palpate {
namespace {

constexpr std::size_t kMinKept = 64;        // samples per finger
constexpr std::size_t kMaxUnitLength = 16;  // [characters]
constexpr double kMaxKeptTime = 0.5;        // [s] of samples at the scene's rate
constexpr double kMissing = 1.5;  // periods to the next sample beyond which one is missing

using Sample = FingerStream::Sample;

}  // namespace

struct TactileInbox::State {
  explicit State(const Tactile& tactile) : period(Seconds(1 / tactile.rate)) {
    const auto kept = static_cast<std::size_t>(std::lround(kMaxKeptTime * tactile.rate));
    for (const Finger& finger : tactile.fingers) {
      fingers.emplace_back(finger.name, tactile.channels, period, std::max(kMinKept, kept));
    }
  }

  FingerStream* Find(std::string_view name) {
    const auto found = std::ranges::find(fingers, name, &FingerStream::name);
    return found == fingers.end() ? nullptr : &*found;
  }
  std::optional<Time> Newest() const;
  std::size_t Leader(Time now) const;
  std::optional<Time> NextInstant(std::size_t leader);
  std::optional<TactileFrame> TryFrame();
  TactileFrame FrameOf(Time t);

  const Clock::duration period;

  PriorityInheritanceMutex mutex;  // guards the members below
  PriorityInheritanceCondition fed;
  std::vector<FingerStream> fingers;
  std::array<bool, kMaxFingers> was_present{}, is_absent{};
  std::optional<Time> last;  // time of the last frame
  std::size_t led = 0;       // the finger whose sample gave its time
  bool after_gap = false;    // whether a gap precedes the next frame
  std::uint64_t frames = 0;
};

// Returns the newest sample time of any finger. It serves as the present time, so that fingers are
// compared with each other and not with the wall clock.
std::optional<Time> TactileInbox::State::Newest() const {
  std::optional<Time> newest;
  for (const FingerStream& finger : fingers) {
    const Sample* sample = finger.newest();
    if (sample != nullptr && (!newest || sample->at > *newest)) newest = sample->at;
  }
  return newest;
}

// nullopt: the leading finger has not sent enough samples yet.
std::optional<Time> TactileInbox::State::NextInstant(std::size_t leader) {
  const FingerStream& finger = fingers[leader];
  if (!last) return finger.After(Time::min())->at;
  // The samples of another leading finger have other times, so the first may follow the last frame
  // too soon.
  const Sample* next = finger.After(*last + (leader == led ? Clock::duration(0) : period / 2));
  if (next == nullptr) return std::nullopt;
  Time t = *last + period;
  const Clock::duration ahead = next->at - *last;
  if (finger.KeepsRate()) {
    const bool is_next = SecondsBetween(*last, next->at) <= kMissing * SecondsBetween(*last, t);
    t = is_next ? next->at : *last + ahead / ((ahead + period / 2) / period);
  } else if (!next->begins) {
    next = finger.After(t - Clock::duration(1));
    if (next == nullptr) return std::nullopt;
  }
  if (!next->begins) return t;
  after_gap = after_gap || was_present[leader];
  return next->at;
}

// Returns the first finger without a gap before its next sample; if all have one, the finger that
// resumes first.
std::size_t TactileInbox::State::Leader(Time now) const {
  std::size_t leader = fingers.size();
  Time back = Time::max();
  for (std::size_t i = 0; i < fingers.size(); ++i) {
    if (!fingers[i].IsSending(now)) continue;
    const Sample* next = fingers[i].After(last.value_or(Time::min()));
    if (next == nullptr || !next->begins) return i;
    if (next->at < back) {
      back = next->at;
      leader = i;
    }
  }
  return leader;
}

std::optional<TactileFrame> TactileInbox::State::TryFrame() {
  const auto now = Newest();
  if (!now) return std::nullopt;
  const std::size_t leader = Leader(*now);
  const auto t = NextInstant(leader);
  if (!t) return std::nullopt;
  for (const FingerStream& finger : fingers) {
    if (finger.IsSending(*now) && finger.newest()->at < *t) return std::nullopt;
  }
  led = leader;
  return FrameOf(*t);
}

TactileFrame TactileInbox::State::FrameOf(Time t) {
  TactileFrame frame;
  frame.sequence = ++frames;
  frame.sensed_at = t;
  for (std::size_t i = 0; i < fingers.size(); ++i) {
    frame.fingers[i] = fingers[i].At(t);
    const bool is_present = frame.fingers[i].present;
    if (is_present && is_absent[i] && was_present[i]) after_gap = true;
    is_absent[i] = !is_present;
    was_present[i] = was_present[i] || is_present;
    fingers[i].Forget(t);
  }
  frame.after_gap = std::exchange(after_gap, false);
  last = t;
  return frame;
}

TactileInbox::TactileInbox(const Tactile& tactile) : state_(std::make_unique<State>(tactile)) {}

TactileInbox::~TactileInbox() = default;

std::optional<TactileInbox::Refusal> TactileInbox::Feed(std::string_view finger,
                                                        std::uint64_t sequence, Time sensed_at,
                                                        const FingerReading& reading,
                                                        Time arrived_at, SenderId sender,
                                                        std::string_view unit) {
  {
    const std::scoped_lock lock(state_->mutex);
    FingerStream* const stream = state_->Find(finger);
    if (stream == nullptr) {
      std::string known;
      for (const FingerStream& one : state_->fingers) {
        known.append(known.empty() ? "" : ", ").append(one.name());
      }
      return Refusal{"is not a finger of this scene: expected " + known};
    }
    if (!unit.empty() && unit != stream->unit()) {
      return Refusal{"unit = " + Presentable(unit, kMaxUnitLength) + ": expected " +
                     stream->unit()};
    }
    if (auto why = stream->Take(sequence, sensed_at, reading, arrived_at, sender)) {
      return Refusal{std::move(*why)};
    }
  }
  state_->fed.notify_all();
  return std::nullopt;
}

void TactileInbox::Leave(std::string_view finger, SenderId sender) {
  const std::scoped_lock lock(state_->mutex);
  if (FingerStream* const stream = state_->Find(finger)) stream->Leave(sender);
}

std::optional<TactileFrame> TactileInbox::Next(const std::stop_token& stop) {
  std::unique_lock lock(state_->mutex);
  // With a driven clock the waiting thread itself would have to feed the samples.
  if (DrivenClock::is_active()) return state_->TryFrame();
  std::optional<TactileFrame> frame;
  state_->fed.wait(lock, stop, [&] {
    if (!frame) frame = state_->TryFrame();
    return frame.has_value();
  });
  return stop.stop_requested() ? std::nullopt : frame;
}

std::string TactileInbox::description() const {
  const std::scoped_lock lock(state_->mutex);
  std::string names;
  for (const FingerStream& finger : state_->fingers) {
    names.append(names.empty() ? "" : ", ").append(finger.name());
  }
  return "stream of " + names;
}

}  // namespace palpate
