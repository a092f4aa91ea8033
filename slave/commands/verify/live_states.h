// The states of a slave that serves.
#pragma once

#include <filesystem>
#include <memory>
#include <optional>
#include <stop_token>
#include <string>
#include <vector>

#include "shared/state/clock.h"
#include "slave/verify/force_table.h"

namespace palpate {

class LiveStates {
 public:
  // `tls`: folder of certificates; empty: plain text. Throws std::invalid_argument: no address, or
  // beyond loopback in plain text without `insecure`.
  LiveStates(const std::string& address, const std::filesystem::path& tls, bool insecure);
  ~LiveStates();

  // Returns the states of the next `seconds` of samples, one per sample. Time zero is the first
  // state of the first call. The measured force is that at the time of the sample. A failed
  // connection is reopened; a total of 5 s without states ends the watch. Throws
  // std::runtime_error: there is no state.
  std::vector<ForceRow> Watch(double seconds, const std::stop_token& stop);

 private:
  struct Connection;

  std::string address_;
  std::unique_ptr<Connection> connection_;
  std::optional<Time> start_;  // of the clock
  double last_ = 0;            // time of the last state
};

}  // namespace palpate
