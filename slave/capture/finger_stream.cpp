#include <algorithm>
#include <cmath>
#include <utility>

#include "slave/capture/tactile_inbox.h"
#include "slave/capture/tactile_recording.h"

namespace palpate {
namespace {

// Silence of a driver after which another sender is accepted.
constexpr Clock::duration kDriverSilence = std::chrono::seconds(1);
constexpr int kDrivers = 20;  // samples without a gap after which a sender counts as a driver
constexpr double kMaxDistance = 1e6;  // [m]
constexpr double kRigid = 1e-6;       // tolerance of a rotation matrix
// Largest period of a sender, relative to the scene's period; slower samples are separated by gaps.
constexpr double kSlowestSender = 10;
constexpr double kPeriodTolerance = 0.1;  // tolerance of the period, relative to the scene's
constexpr double kSmoothing = 0.05;       // share of the newest interval in the sender's period

std::optional<std::string> RefuseCounts(const FingerReading& reading,
                                        const TactileChannels& channels) {
  const std::size_t count = reading.channels.size();
  if (count != static_cast<std::size_t>(channels.count)) {
    return "has " + std::to_string(count) +
           (channels.are_electrodes() ? " electrodes: expected " : " channels: expected ") +
           std::to_string(channels.count) + ", " + channels.Names();
  }
  const auto is_count = [](float x) { return std::abs(static_cast<double>(x)) <= kMaxCounts; };
  const auto refuse = [&](const std::string& which, float value) {
    return which + " = " + std::to_string(value) + ": expected a finite number of " + channels.unit;
  };
  for (std::size_t i = 0; i < reading.channels.size(); ++i) {
    if (is_count(reading.channels[i])) continue;
    return refuse((channels.are_electrodes() ? "electrode " : "channel ") +
                      channels.NameOf(static_cast<int>(i)),
                  reading.channels[i]);
  }
  if (!is_count(reading.pac)) return refuse("pressure pac", reading.pac);
  if (!is_count(reading.pdc)) return refuse("pressure pdc", reading.pdc);
  return std::nullopt;
}

bool IsPose(const Eigen::Isometry3d& X) {
  const Eigen::Matrix3d R = X.linear();
  const bool is_rotation =
      ((R * R.transpose()) - Eigen::Matrix3d::Identity()).norm() < kRigid && R.determinant() > 0;
  return is_rotation && X.translation().norm() <= kMaxDistance;  // so written, NaN is refused too
}

}  // namespace

FingerStream::FingerStream(std::string name, TactileChannels channels, Clock::duration period,
                           std::size_t capacity)
    : name_(std::move(name)),
      channels_(std::move(channels)),
      period_(std::chrono::duration<double>(period).count()),
      sender_period_(period_),
      ring_(capacity) {}

std::optional<std::string> FingerStream::Take(std::uint64_t sequence, Time sensed_at,
                                              const FingerReading& reading, Time arrived_at,
                                              SenderId sender) {
  if (sensed_at_ && sender != sender_ && arrived_at - arrived_at_ < SilenceAllowed()) {
    return "is already fed by a stream: expected one stream, or a new one a second after the "
           "last sample";
  }
  if (auto why = RefuseCounts(reading, channels_)) return why;
  if (reading.X_SF && !IsPose(*reading.X_SF)) {
    return "pose: expected a finite position and a rotation";
  }
  if (sender != sender_) Restart();
  if (auto why = RefuseOrder(sequence, sensed_at)) return why;
  if (sensed_at_ && sensed_at == *sensed_at_) return std::nullopt;  // the same sample again
  Sample sample{clock_.Map(sensed_at, arrived_at), !sensed_at_, reading};
  sample.reading.present = true;
  if (sensed_at_) {
    const double interval = SecondsBetween(*sensed_at_, sensed_at);
    const double longest = kMaxPause * std::max(period_, sender_period_);
    sample.begins = interval > longest;
    sender_period_ += kSmoothing * (std::min(interval, longest) - sender_period_);
    sender_period_ = std::min(sender_period_, kSlowestSender * period_);
  }
  // Times must rise, even if a new fastest sample changes the clock offset.
  if (newest() != nullptr) sample.at = std::max(sample.at, newest()->at + Clock::duration(1));
  run_ = sample.begins ? 1 : std::min(run_ + 1, kDrivers);
  sender_ = sender;
  arrived_at_ = arrived_at;
  sequence_ = sequence;
  sensed_at_ = sensed_at;
  Push(sample);
  return std::nullopt;
}

// Compares with the last sample of the present sender.
std::optional<std::string> FingerStream::RefuseOrder(std::uint64_t sequence, Time sensed_at) const {
  if (!sensed_at_ || sensed_at == *sensed_at_) return std::nullopt;
  if (sensed_at < *sensed_at_) {
    return "sensed_at: expected a time that does not decrease; this one decreased by " +
           std::to_string(SecondsBetween(sensed_at, *sensed_at_)) + " s";
  }
  if (sequence == 0 || sequence > sequence_) return std::nullopt;
  return "sequence = " + std::to_string(sequence) + ": expected one above the last, " +
         std::to_string(sequence_);
}

void FingerStream::Leave(SenderId sender) noexcept {
  if (sender == sender_) Restart();
}

void FingerStream::Restart() noexcept {
  sensed_at_.reset();
  clock_.Reset();
  sender_period_ = period_;
}

// A driver that rarely sends a sample does not block another driver.
Clock::duration FingerStream::SilenceAllowed() const noexcept {
  return run_ < kDrivers ? std::min(kDriverSilence, Seconds(kSlowestSender * period_))
                         : kDriverSilence;
}

Clock::duration FingerStream::max_silence() const noexcept {
  return Seconds(kMaxPause * std::max(period_, sender_period_));
}

bool FingerStream::IsSending(Time now) const noexcept {
  return count_ > 0 && now - Get(count_ - 1).at <= max_silence();
}

bool FingerStream::KeepsRate() const noexcept {
  return std::abs(sender_period_ - period_) <= kPeriodTolerance * period_;
}

const FingerStream::Sample* FingerStream::newest() const noexcept {
  return count_ > 0 ? &Get(count_ - 1) : nullptr;
}

const FingerStream::Sample* FingerStream::After(Time t) const noexcept {
  for (std::size_t i = 0; i < count_; ++i) {
    if (Get(i).at > t) return &Get(i);
  }
  return nullptr;
}

FingerReading FingerStream::At(Time t) const noexcept {
  for (std::size_t i = 0; i < count_; ++i) {
    const Sample& sample = Get(i);
    if (sample.at < t) continue;
    if (sample.at == t) return sample.reading;
    if (i == 0 || sample.begins) break;
    const Sample& before = Get(i - 1);
    return Between(before.reading, sample.reading,
                   SecondsBetween(before.at, t) / SecondsBetween(before.at, sample.at));
  }
  return {};
}

void FingerStream::Forget(Time t) noexcept {
  while (count_ > 1 && Get(1).at <= t) DropFirst();
}

void FingerStream::Push(const Sample& sample) noexcept {
  if (count_ == ring_.size()) {
    DropFirst();
    ring_[first_].begins = true;
  }
  ring_[(first_ + count_) % ring_.size()] = sample;
  ++count_;
}

void FingerStream::DropFirst() noexcept {
  first_ = (first_ + 1) % ring_.size();
  --count_;
}

}  // namespace palpate
