// The slave's door, before gRPC: how many come in, whether they begin as our clients do, and who
// sends more than anyone needs.
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

// Whether `bytes`, the first that came, are one, or may become one.
enum class Greets : std::uint8_t { kYes, kNotYet, kNo };
Greets CheckGreeting(Greeting greeting, std::string_view bytes);

// Why connections were not handed on, or were cut.
enum class TurnedAway : std::uint8_t {
  kSaidNothing,  // no greeting in time, or too many others waited with theirs
  kSaidOther,    // what came is no greeting
  kTooMany,      // of this address, or in all
  kTooMuch,      // bytes: see ConnectionBudget
  kUntrusted,    // not any more: see KeepWhile
};
inline constexpr std::size_t kTurnedAwayCount = 5;
std::string_view ToString(TurnedAway why);

struct AcceptorCounts {
  std::uint64_t accepted = 0;  // handed on
  std::array<std::uint64_t, kTurnedAwayCount> turned_away{};
  std::uint64_t open = 0, waiting = 0;  // now: handed on; with their greeting
  double unseen = 0;                    // since somebody was last looked for [s]
};

class Acceptor {
 public:
  struct Limits {
    std::size_t connections = 512;  // handed on, in all; fewer where descriptors are few
    std::size_t per_address = 128;  // IPv6: of a /64
    std::size_t waiting = 256;      // with their greeting; then the eldest goes
    std::chrono::milliseconds greeting{3000};
    double idle = 5;      // [s] without a byte either way: may be cut where others have no place
    double closed = 0.5;  // [s] to an address that sent too much
    double share = 1;     // of ConnectionBudget's
    double rate = 50, burst = 256;  // handed on of an address: [1/s], at once
  };
  // Takes over a connection: open, not blocking. Called from the acceptor's thread.
  using HandOn = std::function<void(int fd)>;

  // Listens. Throws as ListenAt does.
  Acceptor(Endpoint endpoint, Greeting greeting, HandOn hand_on, const Limits& limits);
  ~Acceptor();

  // Lets in, from now on.
  void Start();

  [[nodiscard]] const Endpoint& endpoint() const { return endpoint_; }  // the real port
  [[nodiscard]] AcceptorCounts counts() const;                          // thread-safe
  // Cuts the connection of `peer`, as gRPC names it, when `trusted` is false: asked once a second,
  // by the acceptor's thread. Nothing where no such connection is open. Thread-safe.
  void KeepWhile(const std::string& peer, std::function<bool()> trusted);
  // The connection of `peer` carries pictures or meshes: while somebody operates from another one,
  // what is sent there is paced, as BulkPace has it. Thread-safe.
  void Pace(const std::string& peer);
  // A state's way to the operator at `peer` and back took so long [s]. Thread-safe, short.
  void HearRoundTrip(const std::string& peer, double round_trip);
  // Nobody comes in any more; who is in stays. Idempotent.
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
  PriorityInheritanceMutex mutex_;                        // guards what follows
  std::map<std::string, std::function<bool()>> trusted_;  // of peers, not looked at yet
  std::vector<std::string> paced_;                        // likewise
  std::string operator_;                                  // the newest one's connection
  BulkPace pace_;
  std::jthread thread_;
};

}  // namespace palpate
