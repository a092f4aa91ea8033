// A mutex for threads of different priority.
#pragma once

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

 private:
  pthread_mutex_t mutex_;
};

}  // namespace palpate
