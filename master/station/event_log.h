// The newest fifty events as text, for the page's list.
#pragma once

#include <deque>
#include <mutex>
#include <optional>
#include <string>
#include <vector>

#include "master/haptics/tick_record.h"
#include "master/session/session.h"
#include "master/station/moment_json.h"

namespace palpate {

class EventLog {
 public:
  // Adds an event at `t` [s] since the start of the run. A repetition within half a second is
  // ignored. Thread-safe, as are all functions but AppendChanges.
  void Append(double t, bool is_trouble, std::string text);
  // Adds changes of the operator state and actions of the operator. Called by one thread.
  void AppendChanges(double t, const TickRecord& tick);
  // Adds events of the slave, except contacts, which are too frequent.
  void AppendEvents(double t, Events events);
  // The list, newest last; empty without a new event since the last call.
  std::optional<std::vector<LogEntry>> TakeNew();

 private:
  static constexpr std::size_t kMaxKept = 50;

  std::mutex mutex_;  // guards the members below
  std::deque<LogEntry> entries_;
  std::uint64_t number_ = 0;
  bool is_news_ = false;
  std::optional<TickRecord> last_;  // used by the thread of the ticks
};

}  // namespace palpate
