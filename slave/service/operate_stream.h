// The operator's stream: commands in, states out, one of each in flight. It owns itself from Open
// until gRPC is done with it.
#pragma once

#include <atomic>
#include <memory>
#include <mutex>
#include <optional>
#include <string>

#include <grpcpp/support/server_callback.h>

#include "palpate/v1/state.pb.h"

#include "shared/link/state_mailbox.h"
#include "slave/service/operator_lease.h"
#include "slave/service/publisher.h"

namespace palpate {

// A reactor, because the stream must end with a status of ours while a read is waiting, which a
// blocking handler cannot. gRPC is never called with the mutex held (callbacks may run inside), and
// Finish waits until no write is in flight and no read is being started.
class OperateStream final : public grpc::ServerBidiReactor<v1::OperatorCommand, v1::SlaveState>,
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
  void Close() override;

  void OnReadDone(bool ok) override;
  void OnWriteDone(bool ok) override;
  void OnCancel() override;
  void OnDone() override;

 private:
  explicit OperateStream(const Host& host) : host_(host) {}

  void ReadNext();
  // Gives the lease back and ends the stream with `status` as soon as that is possible. The first
  // status counts.
  void End(const grpc::Status& status);
  void FinishIfQuiet();

  const Host host_;
  std::shared_ptr<OperateStream> self_;  // until OnDone
  std::atomic<OperatorLease::Ticket> ticket_{0};
  v1::OperatorCommand command_;  // gRPC's while a read is waiting
  v1::SlaveState message_;       // gRPC's while `writing_`
  StateMailbox box_;

  std::mutex mutex_;  // guards what follows
  std::optional<grpc::Status> ending_;
  int arming_reads_ = 0;  // threads that are inside StartRead
  bool writing_ = false, finished_ = false;
};

}  // namespace palpate
