#include "slave/capture/decode_ahead.h"

#include <utility>

namespace palpate {

DecodeAhead::DecodeAhead(Decode decode, Options options)
    : decode_(std::move(decode)),
      options_(std::move(options)),
      start_(Clock::now()),
      thread_([this](const std::stop_token& stop) { Run(stop); }) {}

std::optional<Frame> DecodeAhead::Next(const std::stop_token& stop) {
  std::unique_lock lock(mutex_);
  changed_.wait(lock, stop, [this] { return !ready_.empty() || ended_; });
  if (stop.stop_requested()) return std::nullopt;
  if (ready_.empty()) {
    if (failure_) std::rethrow_exception(failure_);
    return std::nullopt;
  }
  Frame frame = std::move(ready_.front());
  ready_.pop_front();
  lock.unlock();
  changed_.notify_all();
  if (options_.paced && !options_.live) WaitForStamp(frame, stop);
  if (stop.stop_requested()) return std::nullopt;
  return frame;
}

void DecodeAhead::WaitForStamp(const Frame& frame, const std::stop_token& stop) {
  std::unique_lock lock(mutex_);
  changed_.wait_until(lock, stop, Clock::ToSteady(frame.sensed_at), [] { return false; });
}

void DecodeAhead::Run(const std::stop_token& stop) {
  std::exception_ptr failure;
  try {
    for (std::uint64_t sequence = 1; !stop.stop_requested(); ++sequence) {
      cv::Mat image = decode_();
      if (image.empty()) break;
      if (!Push({std::move(image), sequence, StampOf(sequence)}, stop)) break;
    }
  } catch (...) {
    failure = std::current_exception();
  }
  {
    const std::lock_guard lock(mutex_);
    ended_ = true;
    failure_ = failure;
  }
  changed_.notify_all();
}

Time DecodeAhead::StampOf(std::uint64_t sequence) const {
  if (options_.live) return Clock::now();
  const std::uint64_t k = sequence - 1;
  const std::uint64_t instant = k < options_.instants.size() ? options_.instants[k] : k;
  return start_ + Seconds(static_cast<double>(instant) / options_.rate);
}

bool DecodeAhead::Push(Frame frame, const std::stop_token& stop) {
  {
    std::unique_lock lock(mutex_);
    if (options_.live) {
      while (ready_.size() >= kLiveAhead) ready_.pop_front();
    } else if (!changed_.wait(lock, stop, [this] { return ready_.size() < kRecordedAhead; })) {
      return false;
    }
    ready_.push_back(std::move(frame));
  }
  changed_.notify_all();
  return true;
}

}  // namespace palpate
