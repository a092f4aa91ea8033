// Sends the emergency stop to the slave on separate threads: in every command of the haptic loop,
// and by a call of Stop, which also works without operating.
#pragma once

#include <atomic>
#include <functional>
#include <thread>

#include "master/haptics/stop_requests.h"

namespace palpate {

class StopPath {
 public:
  struct Ways {
    std::function<bool()> asked;  // polled every few milliseconds; may be empty
    std::function<bool()>
        call;  // calls the slave's Stop; true: it stopped. May block; may be empty
    std::function<void()> give_up = {};  // cancels a running `call`
  };
  // `stops` must outlive this object.
  StopPath(StopRequests& stops, Ways ways);
  // Gives a requested stop up to one second to complete.
  ~StopPath();
  StopPath(const StopPath&) = delete;
  StopPath& operator=(const StopPath&) = delete;

 private:
  StopRequests& stops_;
  std::function<void()> give_up_;
  std::atomic<bool> calls_{false};  // the calling thread runs
  std::jthread watching_, calling_;
};

}  // namespace palpate
