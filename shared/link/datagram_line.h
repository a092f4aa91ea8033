// Datagrams beside a stream, for states and commands, of which only the newest counts. The stream
// hands over the keys and stays in control. Datagrams without these keys are ignored and never
// answered.
#pragma once

#include <atomic>
#include <cstdint>
#include <functional>
#include <optional>
#include <string_view>
#include <thread>

#include <sys/socket.h>

#include "shared/link/datagram_pace.h"
#include "shared/link/datagram_seal.h"
#include "shared/link/priority_inheritance_mutex.h"
#include "shared/state/clock.h"

namespace palpate {

class DatagramLine {
 public:
  struct Keys {
    DatagramKey send, receive;
  };
  // Feedback of the peer: count of received datagrams, and the round trip [s].
  struct LinkFeedback {
    DatagramCount seen = {};
    double round_trip = 0;
  };
  // Called on this object's thread with a decrypted message, valid until it returns.
  using Take = std::function<LinkFeedback(std::string_view plain)>;
  enum class Role : std::uint8_t {
    kCalls,    // sends to a known address
    kAnswers,  // answers the source of the newest authentic datagram
  };

  // A path without datagrams for this time counts as dead.
  static constexpr std::chrono::seconds kSilence{1};

  // `at`: the peer's address for kCalls, the own address for kAnswers. If that port is in use,
  // another one is taken. Throws std::system_error without a socket or with an invalid address.
  DatagramLine(Role role, const sockaddr_storage& at, const Keys& keys, Take take);
  // No callback is called afterwards.
  ~DatagramLine();
  DatagramLine(const DatagramLine&) = delete;
  DatagramLine& operator=(const DatagramLine&) = delete;

  // Sends without waiting or guarantee. Messages that are too large, have no known peer, or exceed
  // the pace (see DatagramPace) are dropped. Call it from one thread at a time.
  void Send(std::string_view plain) noexcept;
  // The stream has written one more message. Thread-safe.
  void StreamMoves() noexcept;
  // Count of received datagrams, for the peer. Thread-safe.
  [[nodiscard]] DatagramCount seen() const { return {newest_, received_}; }
  // Port of this end.
  [[nodiscard]] std::uint16_t port() const;

 private:
  // A file descriptor, closed by the destructor.
  struct Descriptor {
    explicit Descriptor(int opened);  // throws std::system_error if invalid
    ~Descriptor();
    Descriptor(const Descriptor&) = delete;
    Descriptor& operator=(const Descriptor&) = delete;
    const int fd;
  };

  void Run(const std::stop_token& stop);
  void TakeNext();
  // Limits the number of processed datagrams per time, against floods.
  void Pace();

  const Role role_;
  const Descriptor socket_, wake_;
  const Take take_;
  DatagramSealer sealer_;
  DatagramOpener opener_;  // used by the thread only, like the next two
  Time window_{};
  int looked_at_ = 0;
  std::atomic<std::uint64_t> newest_{0}, received_{0};
  PriorityInheritanceMutex mutex_;        // guards the next three
  std::optional<sockaddr_storage> peer_;  // nullopt: unknown yet; always set for kCalls
  Time heard_at_{};
  DatagramPace pace_;
  std::jthread thread_;  // last: it uses all of the above
};

}  // namespace palpate
