// The streams that were refused within the last minute, for Status.alarms. Thread-safe.
#pragma once

#include <deque>
#include <mutex>
#include <string>
#include <utility>

#include "palpate/v1/telemetry.pb.h"

#include "shared/link/priority_inheritance_mutex.h"
#include "shared/state/clock.h"

namespace palpate {

class RefusedStreams {
 public:
  void Add(const std::string& call, const std::string& client, const std::string& why) {
    const std::scoped_lock lock(mutex_);
    newest_.emplace_front(call + " of " + client + " was refused: " + why, Clock::now());
    if (newest_.size() > kMost) newest_.pop_back();
  }
  void FillStatus(v1::Status* status) const {
    const std::scoped_lock lock(mutex_);
    for (const auto& [words, at] : newest_) {
      if (SecondsBetween(at, Clock::now()) < kReported) status->add_alarms(words);
    }
  }

 private:
  static constexpr std::size_t kMost = 16;
  static constexpr double kReported = 60;  // [s]

  mutable PriorityInheritanceMutex mutex_;  // guards the member below
  std::deque<std::pair<std::string, Time>> newest_;
};

}  // namespace palpate
