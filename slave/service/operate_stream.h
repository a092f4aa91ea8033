// The operator's stream: commands in, states out, one of each in flight.
#pragma once

#include <atomic>
#include <string>

#include <grpcpp/support/server_callback.h>

#include "palpate/v1/state.pb.h"

#include "shared/link/state_mailbox.h"
#include "slave/service/operator_lease.h"
#include "slave/service/publisher.h"
#include "slave/service/status.h"

namespace palpate {

class OperateStream final
    : public EndingStream<grpc::ServerBidiReactor<v1::OperatorCommand, v1::SlaveState>>,
      public StateReader {
 public:
  struct Host {
    OperatorLease& lease;
    Publisher& publisher;
    std::atomic<std::uint64_t>& states_sent;
  };

  // Asks for the lease in the name of `peer`; the reactor to hand to gRPC, also when refused.
  static grpc::ServerBidiReactor<v1::OperatorCommand, v1::SlaveState>* Open(
      const Host& host, const std::string& peer);

  void Offer(const SlaveState& state) override;
  void Close() override { End(Stopping()); }

  void OnReadDone(bool ok) override;
  void OnWriteDone(bool ok) override;

 private:
  explicit OperateStream(const Host& host) : host_(host) {}

  void ReadNext();
  void OnEnding() override { host_.lease.Release(ticket_); }

  const Host host_;
  std::atomic<OperatorLease::Ticket> ticket_{0};
  v1::OperatorCommand command_;  // gRPC's while a read is waiting
  v1::SlaveState message_;       // gRPC's while `writing_`
  StateMailbox box_;
  bool writing_ = false;  // guarded by mutex_
};

}  // namespace palpate
