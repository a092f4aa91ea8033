// Admission control in front of gRPC: limits the number of connections, requires a valid protocol
// preface, and limits what a connection may send.
#pragma once

#include <array>
#include <atomic>
#include <chrono>
#include <cstdint>
#include <functional>
#include <map>
#include <string>
#include <string_view>
#include <thread>
#include <vector>

#include "shared/link/loopback.h"
#include "shared/link/priority_inheritance_mutex.h"
#include "shared/state/clock.h"
#include "slave/service/admission/bulk_pace.h"
#include "slave/service/admission/listening.h"

namespace palpate {

// How a connection begins.
enum class Greeting : std::uint8_t { kHttp2, kTls };

// Whether `bytes`, the first that arrived, are a valid preface, or may become one.
enum class Greets : std::uint8_t { kYes, kNotYet, kNo };
Greets CheckGreeting(Greeting greeting, std::string_view bytes);

// Why connections were not handed on, or were cut.
enum class TurnedAway : std::uint8_t {
  kSaidNothing,  // no greeting in time, or too many others waited with theirs
  kSaidOther,    // the first bytes were not a valid preface
  kTooMany,      // of this address, or in all
  kTooMuch,      // bytes exceeded: see ConnectionBudget
  kUntrusted,    // no longer trusted: see KeepWhile
};
inline constexpr std::size_t kTurnedAwayCount = 5;
std::string_view ToString(TurnedAway why);

struct AcceptorCounts {
  std::uint64_t accepted = 0;  // handed on
  std::array<std::uint64_t, kTurnedAwayCount> turned_away{};
  std::uint64_t open = 0, waiting = 0;  // now: handed on; with their greeting
  double unseen = 0;                    // time since the last poll [s]
};

class Acceptor {
 public:
  struct Limits {
    std::size_t connections = 512;  // handed on, in all; fewer where descriptors are few
    std::size_t per_address = 128;  // IPv6: of a /64
    std::size_t waiting = 256;      // limit with a valid preface; beyond it the oldest is closed
    std::chrono::milliseconds greeting{3000};
    double idle =
        5;  // [s] without a byte in either direction, after which it may be closed for others
    double closed = 0.5;            // [s] to an address that sent too much
    double share = 1;               // of ConnectionBudget's
    double rate = 50, burst = 256;  // handed on of an address: [1/s], at once
  };
  // Takes over a connection: open, non-blocking. Called from the acceptor's thread.
  using HandOn = std::function<void(int fd)>;

  // Listens. Throws as ListenAt does.
  Acceptor(Endpoint endpoint, Greeting greeting, HandOn hand_on, const Limits& limits);
  ~Acceptor();

  // Lets in, from now on.
  void Start();

  [[nodiscard]] const Endpoint& endpoint() const { return endpoint_; }  // the real port
  [[nodiscard]] AcceptorCounts counts() const;                          // thread-safe
  // Closes the connection of `peer` (gRPC's name) when `trusted` returns false. It is called once
  // per second by the acceptor's thread. No effect if there is no such connection. Thread-safe.
  void KeepWhile(const std::string& peer, std::function<bool()> trusted);
  // Marks the connection of `peer` as a stream of images or meshes. While an operator uses another
  // connection, its rate is limited by BulkPace. Thread-safe.
  void Pace(const std::string& peer);
  // Reports a measured round-trip time of the operator at `peer` [s]. Thread-safe, short.
  void HearRoundTrip(const std::string& peer, double round_trip);
  // Accepts no new connections; existing ones stay. Idempotent.
  void Stop();

 private:
  class Room;

  Endpoint endpoint_;
  const Greeting greeting_;
  const HandOn hand_on_;
  const Limits limits_;
  std::vector<ListeningSocket> sockets_;
  std::array<std::atomic<std::uint64_t>, kTurnedAwayCount> turned_away_{};
  std::atomic<std::uint64_t> accepted_{0}, open_{0}, waiting_{0};
  std::atomic<Time> looked_{Clock::now()};
  PriorityInheritanceMutex mutex_;                        // guards the members below
  std::map<std::string, std::function<bool()>> trusted_;  // new peers, not yet processed
  std::vector<std::string> paced_;                        // new peers, not yet processed
  std::string operator_;                                  // the newest one's connection
  BulkPace pace_;
  std::jthread thread_;
};

}  // namespace palpate
