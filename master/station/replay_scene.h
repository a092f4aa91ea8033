// What stays as it is over a recording, or changes rarely, and hence is read before it is played:
// what the slave said of itself, and the log.
#pragma once

#include <map>
#include <stop_token>
#include <string>
#include <vector>

#include "master/link/slave_status_poller.h"
#include "master/recording/replay.h"
#include "master/station/moment_json.h"

namespace palpate {

class ReplayScene {
 public:
  // Reads the recording through. Throws InputError: a message is damaged.
  ReplayScene(const Replay& replay, const std::string& file);

  [[nodiscard]] const StationHello& hello() const { return hello_; }
  // That another build than `own` recorded it, in words; empty: it did not, or is not told.
  [[nodiscard]] std::string OtherBuild(const std::string& own) const;
  // What the slave had said of itself by `t` [s].
  [[nodiscard]] SlaveStatusPoller::Words WordsAt(double t) const;
  // The newest of the log by `t` [s], the newest last.
  [[nodiscard]] std::vector<LogEntry> SaidBy(double t) const;

 private:
  using StatesByTime = std::map<double, std::string>;  // JSON, by its time [s]

  void TakeNote(const McapMap& session);

  StationHello hello_;
  StatesByTime scenes_, capabilities_, health_;
  std::vector<LogEntry> entries_;
};

}  // namespace palpate
