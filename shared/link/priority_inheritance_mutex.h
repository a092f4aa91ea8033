// A mutex and a condition for threads of different priority.
#pragma once

#include <cerrno>
#include <chrono>
#include <ctime>
#include <mutex>
#include <stop_token>
#include <system_error>

#include <pthread.h>

namespace palpate {

// The owner runs at the highest priority of the waiting threads, so that a real-time thread never
// waits for unrelated work. For use with std::scoped_lock.
class PriorityInheritanceMutex {
 public:
  // Throws std::system_error if the system does not support this.
  PriorityInheritanceMutex() {
    pthread_mutexattr_t inherits;
    pthread_mutexattr_init(&inherits);
    pthread_mutexattr_setprotocol(&inherits, PTHREAD_PRIO_INHERIT);
    const int error = pthread_mutex_init(&mutex_, &inherits);
    pthread_mutexattr_destroy(&inherits);
    if (error != 0)
      throw std::system_error(error, std::generic_category(), "PriorityInheritanceMutex");
  }
  ~PriorityInheritanceMutex() { pthread_mutex_destroy(&mutex_); }
  PriorityInheritanceMutex(const PriorityInheritanceMutex&) = delete;
  PriorityInheritanceMutex& operator=(const PriorityInheritanceMutex&) = delete;

  void lock() noexcept { pthread_mutex_lock(&mutex_); }
  void unlock() noexcept { pthread_mutex_unlock(&mutex_); }
  bool try_lock() noexcept { return pthread_mutex_trylock(&mutex_) == 0; }
  pthread_mutex_t* native_handle() noexcept { return &mutex_; }

 private:
  pthread_mutex_t mutex_;
};

// PriorityInheritanceCondition serves PriorityInheritanceMutex as std::condition_variable serves
// std::mutex. std::condition_variable_any is no substitute: it has an ordinary mutex of its own,
// for which a notifying real-time thread waits.
class PriorityInheritanceCondition {
 public:
  PriorityInheritanceCondition() { pthread_cond_init(&condition_, nullptr); }
  ~PriorityInheritanceCondition() { pthread_cond_destroy(&condition_); }
  PriorityInheritanceCondition(const PriorityInheritanceCondition&) = delete;
  PriorityInheritanceCondition& operator=(const PriorityInheritanceCondition&) = delete;

  // `done` and notifications use the lock's mutex. The waits with a stop token also end when a stop
  // is requested; they release the lock before they return and take it again, so that only one
  // thread may make `done` false.
  void notify_one() noexcept { pthread_cond_signal(&condition_); }
  void notify_all() noexcept { pthread_cond_broadcast(&condition_); }
  // Returns the last value of `done`, which is false only after `due`.
  template <class Predicate>
  bool wait_until(std::unique_lock<PriorityInheritanceMutex>& lock,
                  std::chrono::steady_clock::time_point due, const Predicate& done) {
    const auto whole = std::chrono::floor<std::chrono::seconds>(due);
    const std::chrono::nanoseconds rest = due - whole;
    const timespec until{.tv_sec = whole.time_since_epoch().count(), .tv_nsec = rest.count()};
    while (!done()) {
      // steady_clock is CLOCK_MONOTONIC (libstdc++).
      const int error = pthread_cond_clockwait(&condition_, lock.mutex()->native_handle(),
                                               CLOCK_MONOTONIC, &until);
      if (error == ETIMEDOUT) return done();
    }
    return true;
  }
  // Returns the last value of `done`, which is false only after the stop.
  template <class Predicate>
  bool wait(std::unique_lock<PriorityInheritanceMutex>& lock, const std::stop_token& stop,
            const Predicate& done) {
    return WithStop(lock, stop, [&] {
      while (!done() && !stop.stop_requested()) {
        pthread_cond_wait(&condition_, lock.mutex()->native_handle());
      }
      return done();
    });
  }
  // Returns the last value of `done`, which is false only after the stop or after `due`.
  template <class Predicate>
  bool wait_until(std::unique_lock<PriorityInheritanceMutex>& lock, const std::stop_token& stop,
                  std::chrono::steady_clock::time_point due, const Predicate& done) {
    return WithStop(lock, stop, [&] {
      wait_until(lock, due, [&] { return done() || stop.stop_requested(); });
      return done();
    });
  }

 private:
  // The callback locks the mutex, so it is neither made nor removed while this thread holds it.
  template <class Wait>
  bool WithStop(std::unique_lock<PriorityInheritanceMutex>& lock, const std::stop_token& stop,
                const Wait& wait) {
    PriorityInheritanceMutex* const mutex = lock.mutex();
    lock.unlock();
    bool is_done = false;
    {
      const std::stop_callback on_stop(stop, [this, mutex] {
        const std::scoped_lock locked(*mutex);
        notify_all();
      });
      lock.lock();
      is_done = wait();
      lock.unlock();
    }
    lock.lock();
    return is_done;
  }

  pthread_cond_t condition_;
};

}  // namespace palpate
