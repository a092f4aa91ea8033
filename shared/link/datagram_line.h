// Datagrams beside a stream, for what is worth nothing once something newer is there: states and
// commands. The stream stays who decides; whoever has not the keys that it handed over is not
// heard, and never answered.
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
  // What one told of the line: of ours, and how long the way there and back took [s].
  struct LinkFeedback {
    DatagramCount seen = {};
    double round_trip = 0;
  };
  // Called by the line's thread with what was opened, which stands until it returns.
  using Take = std::function<LinkFeedback(std::string_view plain)>;
  enum class Role : std::uint8_t {
    kCalls,    // to an address that is known
    kAnswers,  // to wherever the newest authentic datagram came from, while they come
  };

  // A path on which nothing came for so long is taken for dead.
  static constexpr std::chrono::seconds kSilence{1};

  // Who calls gives the peer's address, who answers its own; where that port is taken, another one
  // serves. Throws std::system_error: no socket, no such address.
  DatagramLine(Role role, const sockaddr_storage& at, const Keys& keys, Take take);
  // Nothing is taken afterwards.
  ~DatagramLine();
  DatagramLine(const DatagramLine&) = delete;
  DatagramLine& operator=(const DatagramLine&) = delete;

  // Never waits, and promises nothing. Too large, nobody there to be answered, or the line too thin
  // for all (see DatagramPace): not sent. One thread at a time.
  void Send(std::string_view plain) noexcept;
  // The stream beside took one more. Thread-safe.
  void StreamMoves() noexcept;
  // Of the peer's, to be told. Thread-safe.
  [[nodiscard]] DatagramCount seen() const { return {newest_, received_}; }
  // Of this end.
  [[nodiscard]] std::uint16_t port() const;

 private:
  // Open until it goes.
  struct Descriptor {
    explicit Descriptor(int opened);  // throws std::system_error: it is none
    ~Descriptor();
    Descriptor(const Descriptor&) = delete;
    Descriptor& operator=(const Descriptor&) = delete;
    const int fd;
  };

  void Run(const std::stop_token& stop);
  void TakeNext();
  // Strangers may send as fast as they like: no more is looked at than so much in a while.
  void Pace();

  const Role role_;
  const Descriptor socket_, wake_;
  const Take take_;
  DatagramSealer sealer_;
  DatagramOpener opener_;  // the thread's own, as are the next two
  Time window_{};
  int looked_at_ = 0;
  std::atomic<std::uint64_t> newest_{0}, received_{0};
  PriorityInheritanceMutex mutex_;        // guards the next three
  std::optional<sockaddr_storage> peer_;  // nullopt: nobody yet; of who calls always
  Time heard_at_{};
  DatagramPace pace_;
  std::jthread thread_;  // last: it uses all of the above
};

}  // namespace palpate
