// Runs slow tasks, such as calls to the slave, one after another on a separate thread, so that
// neither page nor haptic loop waits.
#pragma once

#include <condition_variable>
#include <deque>
#include <functional>
#include <mutex>
#include <stop_token>
#include <thread>

namespace palpate {

class TaskQueue {
 public:
  static constexpr std::size_t kMaxTasks = 4;

  TaskQueue() : thread_([this](const std::stop_token& stop) { Run(stop); }) {}

  // Queues a task and returns at once. False: too many tasks wait. The destructor signals the stop
  // token of the running task and waits for it. Thread-safe.
  bool Submit(std::function<void(const std::stop_token&)> task) {
    const std::scoped_lock lock(mutex_);
    if (tasks_.size() >= kMaxTasks) return false;
    tasks_.push_back(std::move(task));
    changed_.notify_all();
    return true;
  }

 private:
  void Run(const std::stop_token& stop) {
    while (true) {
      std::unique_lock lock(mutex_);
      if (!changed_.wait(lock, stop, [this] { return !tasks_.empty(); })) return;
      const auto task = std::move(tasks_.front());
      tasks_.pop_front();
      lock.unlock();
      task(stop);
    }
  }

  std::mutex mutex_;  // guards what follows
  std::condition_variable_any changed_;
  std::deque<std::function<void(const std::stop_token&)>> tasks_;
  std::jthread thread_;  // last: it uses all of the above
};

}  // namespace palpate
