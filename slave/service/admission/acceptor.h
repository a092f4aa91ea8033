// Admission control in front of gRPC: it limits the number of connections, their rate, and the data
// rate of all of them.
#pragma once

#include <array>
#include <atomic>
#include <cstdint>
#include <functional>
#include <map>
#include <optional>
#include <string>
#include <string_view>
#include <thread>
#include <vector>

#include "shared/link/loopback.h"
#include "shared/link/priority_inheritance_mutex.h"
#include "shared/state/clock.h"

namespace palpate {

// Why a connection was closed.
enum class TurnedAway : std::uint8_t {
  kFull,       // the permitted number of connections was open, and this one had no stream
  kTooMuch,    // the bytes of all connections exceeded the limit, and this one sent most
  kUntrusted,  // its certificate is no longer valid
};
inline constexpr std::array<std::string_view, 3> kTurnedAwayNames{"full", "too_much", "untrusted"};

class Acceptor {
 public:
  struct Limits {
    std::size_t connections = 2048;  // fewer where descriptors are few
    double rate = 1e6;               // of all connections together [bytes/s]
    double burst = 0;                // of all connections together [bytes]; its owner sets it
  };
  // The client of a connection with a stream.
  struct Client {
    // It may send beyond Limits::rate [bytes/s]; of the streams of a connection the largest counts.
    double rate = 0;
    std::function<bool()> trusted = {};  // empty: always; called once per second
  };
  struct Counts {
    std::uint64_t accepted = 0;  // connections that were handed on
    std::uint64_t open = 0;
    std::array<std::uint64_t, kTurnedAwayNames.size()> turned_away{};
  };
  // Receives ownership of an open, non-blocking connection. Called from the acceptor's thread.
  using HandOn = std::function<void(int fd)>;

  // Listens on all addresses that the host has on this machine, at one port. Throws
  // std::runtime_error: host unknown, port in use (no silent sharing), not an address of this
  // machine, not permitted.
  Acceptor(Endpoint endpoint, HandOn hand_on, const Limits& limits);
  ~Acceptor();

  // Accepts connections from now on.
  void Start();

  [[nodiscard]] const Endpoint& endpoint() const { return endpoint_; }  // the real port
  [[nodiscard]] Counts counts() const;                                  // thread-safe
  // Applies `client` to the connection of `peer` (gRPC's name), which is closed when it is not
  // trusted. No effect if there is no such connection. Thread-safe.
  void Describe(const std::string& peer, Client client);
  // Accepts no new connections; existing ones stay. Idempotent.
  void Stop();

 private:
  struct Connection {
    int fd;  // a duplicate: the number of the original may be used again
    std::string peer;
    bool has_stream = false;  // a connection without stream is closed if the limit is reached
    double rate = 0;          // individual rate [bytes/s]
    std::function<bool()> trusted = {};
    std::uint64_t received = 0;  // [bytes] at the last count
    double own = 0;              // amount that it may still send at its own rate [bytes]
    double recent = 0;           // [bytes] beyond that, decaying with a time constant
  };

  void Run(const std::stop_token& stop);
  void AcceptOne(int listener);
  void ApplyClients();
  void CountBytes(double dt);
  void CutUntrusted();
  void Close(int fd, TurnedAway why);

  Endpoint endpoint_;
  const HandOn hand_on_;
  const Limits limits_;
  std::vector<int> listening_;
  std::vector<Connection> connections_;  // used by the thread only, as the next one
  double credit_;                        // amount that may still arrive at once [bytes]
  std::array<std::atomic<std::uint64_t>, kTurnedAwayNames.size()> turned_away_{};
  std::atomic<std::uint64_t> accepted_{0}, open_{0};
  PriorityInheritanceMutex mutex_;         // guards the member below
  std::map<std::string, Client> clients_;  // clients that are not applied yet
  std::jthread thread_;                    // last: it uses all of the above
};

}  // namespace palpate
