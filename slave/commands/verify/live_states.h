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

  // The states of the next `seconds` of samples, one for each. Their clock starts with the first
  // state of all. The measured force is read at the time of the sample. A connection that fails is
  // opened again; 5 s of silence in all end the watch. Throws std::runtime_error: there is no
  // state.
  std::vector<ForceRow> Watch(double seconds, const std::stop_token& stop);

 private:
  struct Connection;

  std::string address_;
  std::unique_ptr<Connection> connection_;
  std::optional<Time> start_;  // of the clock
  double last_ = 0;            // time of the last state
};

}  // namespace palpate
