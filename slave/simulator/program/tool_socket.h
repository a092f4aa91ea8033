// Receives the tool's position in a simulated environment from a driver in another process.
#pragma once

#include <string>
#include <thread>

#include "slave/simulator/environment/simulated_environment.h"

namespace palpate {

// UDP on a free port of 127.0.0.1. Each datagram is the tip `x y z`, frame S [m]; the answer is the
// true force on the tool `x y z` [N]; it is empty while the environment computes none.
class ToolSocket {
 public:
  // `environment` outlives it. Throws std::system_error: no socket.
  explicit ToolSocket(SimulatedEnvironment& environment);
  ~ToolSocket();
  ToolSocket(const ToolSocket&) = delete;
  ToolSocket& operator=(const ToolSocket&) = delete;

  [[nodiscard]] std::string address() const;  // HOST:PORT

 private:
  void Answer();

  SimulatedEnvironment& environment_;
  const int socket_;
  std::jthread thread_;
};

}  // namespace palpate
