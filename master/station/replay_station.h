// The page of a recording: told what a live session's page is told, at the pace that the page asks
// for, with the badge REPLAY. Nothing there moves a hand: what would is refused.
#pragma once

#include <memory>
#include <stop_token>
#include <string>

#include "master/recording/replay.h"
#include "master/station/server/page_access.h"

namespace palpate {

class ReplayStation {
 public:
  struct Options {
    PagePlace at;              // where it is served
    double from = 0;           // [s] after the recording's beginning
    double speed = 1;          // Replay::kSlowest to kFastest
    std::string file;          // its name, for people
    std::string version = {};  // of this program; empty: not told
  };
  // `replay` outlives it. Reads through what the slave said of itself. Throws InputError: a message
  // is damaged; std::runtime_error: it cannot be listened at `at`.
  ReplayStation(const Replay* replay, const Options& options);
  ~ReplayStation();

  // As PageServer::address.
  [[nodiscard]] std::string address() const;
  // Plays until `stop`; at the recording's end it stands there, and goes on from where the page
  // wants it. Throws InputError: a message is damaged.
  void Run(const std::stop_token& stop);

 private:
  struct Parts;
  std::unique_ptr<Parts> parts_;
};

}  // namespace palpate
