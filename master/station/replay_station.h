// The page of a recording. It shows the same data as a live session, at the speed chosen on the
// page, with the badge REPLAY. Commands that would move or stop a tool are rejected.
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
    PagePlace at;              // address of the page
    double from = 0;           // start time in the recording [s]
    double speed = 1;          // Replay::kSlowest to kFastest
    std::string file;          // name of the recording
    std::string version = {};  // of this program; empty: unknown
  };
  // `replay` must outlive this object. Reads the whole recording. Throws InputError if a message is
  // damaged, and std::runtime_error if the address cannot be used.
  ReplayStation(const Replay* replay, const Options& options);
  ~ReplayStation();

  // See PageServer::address.
  [[nodiscard]] std::string address() const;
  // Plays until `stop`. At the end of the recording it waits for a jump by the page. Throws
  // InputError if a message is damaged.
  void Run(const std::stop_token& stop);

 private:
  struct Parts;
  std::unique_ptr<Parts> parts_;
};

}  // namespace palpate
