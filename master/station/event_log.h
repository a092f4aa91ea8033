// What happened, in words, the newest fifty: for the page's list.
#pragma once

#include <deque>
#include <mutex>
#include <optional>
#include <string>
#include <vector>

#include "master/haptics/record/tick_record.h"
#include "master/haptics/session.h"
#include "master/station/moment_json.h"

namespace palpate {

class EventLog {
 public:
  // `t` [s] since the run began. The same words again within half a second are no news.
  // Thread-safe, as is all that follows.
  void Append(double t, bool is_trouble, std::string text);
  // What the operator's state became, and what the operator did. One thread.
  void AppendChanges(double t, const TickRecord& tick);
  // What the slave told, but for contacts, which come and go all the time.
  void AppendEvents(double t, Events events);
  // The newest last; nothing: none came since the last call.
  std::optional<std::vector<LogEntry>> TakeNew();

 private:
  static constexpr std::size_t kKept = 50;

  std::mutex mutex_;  // guards what follows
  std::deque<LogEntry> entries_;
  std::uint64_t number_ = 0;
  bool is_news_ = false;
  std::optional<TickRecord> last_;  // of the thread that brings ticks
};

}  // namespace palpate
