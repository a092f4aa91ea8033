// The states of a slave that serves.
#pragma once

#include <filesystem>
#include <memory>
#include <stdexcept>
#include <stop_token>
#include <string>
#include <vector>

#include "shared/state/clock.h"
#include "slave/commands/verify/known_loads.h"

namespace palpate {

// The slave sent no state.
class NoState : public std::runtime_error {
  using std::runtime_error::runtime_error;
};

class LiveStates {
 public:
  // `tls`: folder of certificates; empty: plain text. Throws std::invalid_argument: no address, or
  // beyond loopback in plain text without `insecure`.
  LiveStates(const std::string& address, const std::filesystem::path& tls, bool insecure);
  ~LiveStates();

  // Appends the states of the next `seconds`, one for each sample. Their clock starts with the
  // first state. The force sensor is read at the time of the sample. Throws NoState: the slave does
  // not answer.
  void Watch(double seconds, const std::stop_token& stop);
  [[nodiscard]] const std::vector<ReportedState>& states() const { return states_; }
  // Time of the last state; 0: there is none.
  [[nodiscard]] double now() const { return states_.empty() ? 0 : states_.back().t; }

 private:
  struct Connection;

  std::string address_;
  std::unique_ptr<Connection> connection_;
  std::vector<ReportedState> states_;
  Time start_{};
};

}  // namespace palpate
