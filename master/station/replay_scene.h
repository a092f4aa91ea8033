// Rarely changing data of a recording, read before the replay: scene, capabilities and status of
// the slave, and the log.
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
  // Reads the whole recording. Throws InputError if a message is damaged.
  ReplayScene(const Replay& replay, const std::string& file);

  [[nodiscard]] const StationHello& hello() const { return hello_; }
  // A text if another build than `own` recorded it; empty if it is the same or unknown.
  [[nodiscard]] std::string OtherBuild(const std::string& own) const;
  // Messages of the slave up to `t` [s].
  [[nodiscard]] SlaveStatusPoller::Words WordsAt(double t) const;
  // The newest log entries up to `t` [s], newest last.
  [[nodiscard]] std::vector<LogEntry> SaidBy(double t) const;

 private:
  using StatesByTime = std::map<double, std::string>;  // JSON by time [s]

  void TakeNote(const McapMap& session);

  StationHello hello_;
  StatesByTime scenes_, capabilities_, health_;
  std::vector<LogEntry> entries_;
};

}  // namespace palpate
