#include "slave/capture/image_queue.h"

#include <utility>

#include "shared/state/driven_clock.h"

namespace palpate {

bool ImageQueue::Push(StereoPair images, std::size_t most, const std::stop_token& stop) {
  {
    std::unique_lock lock(mutex_);
    if (!changed_.wait(lock, stop, [&] { return waiting_.size() < most; })) return false;
    waiting_.push_back(std::move(images));
  }
  changed_.notify_all();
  return true;
}

void ImageQueue::Replace(StereoPair images) {
  {
    const std::lock_guard lock(mutex_);
    waiting_.clear();
    waiting_.push_back(std::move(images));
  }
  changed_.notify_all();
}

void ImageQueue::Close(std::exception_ptr failure) {
  {
    const std::lock_guard lock(mutex_);
    closed_ = true;
    failure_ = std::move(failure);
  }
  changed_.notify_all();
}

void ImageQueue::Clear() {
  const std::lock_guard lock(mutex_);
  waiting_.clear();
}

bool ImageQueue::WaitLocked(std::unique_lock<PriorityInheritanceMutex>& lock,
                            const std::stop_token& stop) {
  changed_.wait(lock, stop, [this] { return closed_ || !waiting_.empty(); });
  return !stop.stop_requested() && !waiting_.empty();
}

bool ImageQueue::Wait(const std::stop_token& stop) {
  std::unique_lock lock(mutex_);
  return WaitLocked(lock, stop);
}

std::optional<StereoPair> ImageQueue::Take(const std::stop_token& stop) {
  std::unique_lock lock(mutex_);
  if (!WaitLocked(lock, stop)) {
    if (failure_ && !stop.stop_requested()) std::rethrow_exception(failure_);
    return std::nullopt;
  }
  StereoPair images = std::move(waiting_.front());
  waiting_.pop_front();
  lock.unlock();
  changed_.notify_all();
  return images;
}

void ImageQueue::WaitUntil(Time time, const std::stop_token& stop) {
  if (DrivenClock::Reach(time)) return;
  std::unique_lock lock(mutex_);
  changed_.wait_until(lock, stop, Clock::ToSteady(time), [] { return false; });
}

}  // namespace palpate
