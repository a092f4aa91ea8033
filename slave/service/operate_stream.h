// OperateStream serves the operator: it reads commands and writes states, one of each at a time. If
// the operator requests it, both also travel by datagram.
#pragma once

#include <atomic>
#include <functional>
#include <memory>
#include <optional>
#include <string>
#include <string_view>
#include <utility>

#include <grpcpp/support/server_callback.h>

#include "palpate/v1/state.pb.h"

#include "shared/link/datagram_line.h"
#include "slave/service/operator_lease.h"
#include "slave/service/publisher.h"
#include "slave/service/state_mailbox.h"
#include "slave/service/status.h"
#include "slave/service/stream_list.h"

namespace palpate {

class OperateStream final
    : public EndingStream<grpc::ServerBidiReactor<v1::OperatorCommand, v1::SlaveState>>,
      public StateReader {
 public:
  // OnStream is called when a stream begins. During the stream its connection may send `rate`
  // [bytes/s].
  using OnStream = std::function<void(const grpc::ServerContextBase& context, double rate)>;
  struct Host {
    OperatorLease& lease;
    Publisher& publisher;
    std::atomic<std::uint64_t>& states_sent;
    RefusedStreams& refused;
    const OnStream& on_stream;
  };

  // Requests the lease for the client of `context`. Returns the reactor for gRPC, also after a
  // rejection.
  static grpc::ServerBidiReactor<v1::OperatorCommand, v1::SlaveState>* Open(
      const Host& host, const grpc::ServerContextBase& context);

  void Offer(const SlaveState& composed) override;
  void Close() override { End(Stopping(host_.lease.is_closed())); }

  void OnReadDone(bool ok) override;
  void OnWriteDone(bool ok) override;
  void OnDone() override;

 private:
  OperateStream(const Host& host, const grpc::ServerContextBase& context);

  void TakeCommand(const v1::OperatorCommand& command);
  // Returns OK if this stream has the lease, else why it was refused.
  grpc::Status RequestLease(const std::optional<std::string>& name);

  void OnEnding() override;
  void OfferDatagrams();
  DatagramLine::LinkFeedback TakeDatagram(std::string_view decrypted);
  // Moves the newest state from `box_` to `message_`. Returns false if there is none. Requires
  // mutex_ to be held.
  bool MakeMessage();
  // Overwrites `message` with the parts that the operator requests.
  void Write(const SlaveState& state, v1::SlaveState* message) const;

  const Host host_;
  const grpc::ServerContextBase& context_;        // valid until OnDone
  const std::string peer_;                        // address of the peer in gRPC's form
  const std::string client_;                      // name of the client in the log
  std::atomic<OperatorLease::Ticket> ticket_{0};  // 0: no lease yet
  v1::OperatorCommand command_;                   // gRPC writes to it while a read is waiting
  v1::SlaveState message_;                        // gRPC reads it while `writing_`
  bool datagrams_asked_ = false;                  // used by the reading thread only
  v1::OperatorCommand datagram_command_;          // used by the datagram thread only
  v1::SlaveState datagram_state_;                 // used by the publisher only
  StateMailbox box_;
  // Requests of the newest command: the moment, and the values of the checks.
  std::atomic<bool> wants_moment_{false}, wants_details_{false};
  bool writing_ = false;                    // guarded by mutex_, as the members below
  std::optional<v1::DatagramOffer> offer_;  // the datagram offer that is not sent yet
  std::shared_ptr<DatagramLine> line_;      // null without datagrams
};

}  // namespace palpate
