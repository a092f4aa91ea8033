// Runs slow tasks, such as calls over the network and writing to a disk, one after another on a
// separate thread, so that no thread of a page, of a haptic loop or of commands waits for them.
#pragma once

#include <cstddef>
#include <deque>
#include <functional>
#include <mutex>
#include <stop_token>
#include <thread>
#include <utility>

#include "shared/link/priority_inheritance_mutex.h"

namespace palpate {

class TaskQueue {
 public:
  using Task = std::function<void(const std::stop_token&)>;

  // `max_tasks`: that may wait.
  explicit TaskQueue(std::size_t max_tasks)
      : max_tasks_(max_tasks), thread_([this](const std::stop_token& stop) { Run(stop); }) {}

  // Queues a task and returns at once. False: too many tasks wait. The destructor signals the stop
  // token of the tasks that are left, and waits for them. Thread-safe.
  bool Submit(Task task) {
    {
      const std::scoped_lock lock(mutex_);
      if (tasks_.size() >= max_tasks_) return false;
      tasks_.push_back(std::move(task));
    }
    changed_.notify_all();
    return true;
  }

 private:
  void Run(const std::stop_token& stop) {
    while (true) {
      std::unique_lock lock(mutex_);
      if (!changed_.wait(lock, stop, [this] { return !tasks_.empty(); })) return;
      const Task task = std::move(tasks_.front());
      tasks_.pop_front();
      lock.unlock();
      task(stop);
    }
  }

  const std::size_t max_tasks_;
  PriorityInheritanceMutex mutex_;  // guards the members below
  PriorityInheritanceCondition changed_;
  std::deque<Task> tasks_;
  std::jthread thread_;  // last: it uses all of the above
};

}  // namespace palpate
