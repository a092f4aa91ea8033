// Publishes the slave's states, meshes, images and status on a NATS server, for any number of
// observers. Each message is sent once for all observers.
#pragma once

#include <string>
#include <string_view>
#include <thread>

#include "shared/nats/nats_connection.h"
#include "slave/live/slave.h"
#include "slave/service/publisher.h"
#include "slave/service/teleoperation_service.h"

namespace palpate {

// It has a thread of ordinary priority with a mailbox, like a Watch call. It sends the newest data,
// and the next only after the server has received them, so a slow or absent server gets fewer
// messages and does not delay other work. Old data are dropped.
class NatsFeed {
 public:
  static constexpr double kStateRate = 30, kBulkRate = 10, kStatusRate = 1;  // at most [Hz]

  // All outlive the feed. Changes of the connection are logged. Throws std::invalid_argument:
  // unusable certificates.
  NatsFeed(const NatsServer& server, Slave& slave, Publisher& publisher,
           TeleoperationService& service);

 private:
  // The messages of one subject.
  struct Kind {
    std::string subject;
    Clock::duration gap;  // between two messages
    Time due{};           // of the next message
    Time sensed_at{};     // of the last message
    double size = 0;      // of the last message [bytes]
  };

  Kind KindOf(std::string_view kind, double rate) const;
  void Run(const std::stop_token& stop);
  void Publish(const SlaveState& state, Time now);
  // Publishes the message that `compose(&message)` makes from a new sample, unless an operator's
  // link needs the bandwidth. `compose` returns false if there is nothing to send.
  template <class Message, class Compose>
  void PublishBulk(const SlaveState& state, Time now, Kind* kind, const Compose& compose);
  // The size of the message [bytes].
  template <class Message>
  double Send(const Message& message, const Kind& kind);

  Slave& slave_;
  Publisher& publisher_;
  TeleoperationService& service_;
  const std::string name_;
  NatsConnection connection_;
  Kind states_, meshes_, images_, statuses_;
  std::string bytes_;    // of the message that is sent
  std::string trouble_;  // the last one that was logged
  std::jthread thread_;  // last: it uses all of the above
};

}  // namespace palpate
