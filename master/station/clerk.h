// Does what takes a while, calls to the slave, one after the other on a thread of its own, so that
// neither page nor haptic loop waits for it.
#pragma once

#include <condition_variable>
#include <deque>
#include <functional>
#include <mutex>
#include <stop_token>
#include <thread>

namespace palpate {

class Clerk {
 public:
  static constexpr std::size_t kMostErrands = 4;

  Clerk() : thread_([this](const std::stop_token& stop) { Run(stop); }) {}

  // What the errand is told is asked to stop when the clerk ends, which waits for it. False: too
  // many wait already. Thread-safe; returns at once.
  bool Ask(std::function<void(const std::stop_token&)> errand) {
    const std::scoped_lock lock(mutex_);
    if (errands_.size() >= kMostErrands) return false;
    errands_.push_back(std::move(errand));
    changed_.notify_all();
    return true;
  }

 private:
  void Run(const std::stop_token& stop) {
    while (true) {
      std::unique_lock lock(mutex_);
      if (!changed_.wait(lock, stop, [this] { return !errands_.empty(); })) return;
      const auto errand = std::move(errands_.front());
      errands_.pop_front();
      lock.unlock();
      errand(stop);
    }
  }

  std::mutex mutex_;  // guards what follows
  std::condition_variable_any changed_;
  std::deque<std::function<void(const std::stop_token&)>> errands_;
  std::jthread thread_;  // last: it uses all of the above
};

}  // namespace palpate
