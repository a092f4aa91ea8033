// A driver's stream of tactile samples. It owns itself from Open until gRPC is done with it.
#pragma once

#include <cstdint>
#include <memory>
#include <mutex>
#include <optional>
#include <set>
#include <string>
#include <vector>

#include <grpcpp/support/server_callback.h>

#include "palpate/v1/state.pb.h"
#include "palpate/v1/teleoperation.pb.h"

#include "slave/capture/tactile_inbox.h"

namespace palpate {

class FeedStreams;

// A reactor, because the stream must end with a status of ours while a read is waiting (see
// OperateStream).
class FeedStream final : public grpc::ServerReadReactor<v1::TactileSample> {
 public:
  // `inbox` outlives the stream; null: the stream is refused. `reply` is gRPC's, until OnDone.
  static grpc::ServerReadReactor<v1::TactileSample>* Open(TactileInbox* inbox, FeedStreams* streams,
                                                          v1::FeedTactileReply* reply);

  // The slave is stopping.
  void Close();

  void OnReadDone(bool ok) override;
  void OnCancel() override;
  void OnDone() override;

 private:
  FeedStream(TactileInbox* inbox, v1::FeedTactileReply* reply);

  // The first sentence about this sample that must be said; empty: it was taken.
  std::string Feed();
  void ReadNext();
  void End(const grpc::Status& status);
  void FinishIfQuiet();
  // A thread begins to start a read or to take a sample; false: the stream is ending.
  bool Enter();
  void Exit();

  TactileInbox* const inbox_;
  const TactileInbox::SenderId sender_;
  v1::FeedTactileReply* const reply_;
  std::shared_ptr<FeedStream> self_;  // until OnDone
  v1::TactileSample sample_;          // gRPC's while a read is waiting
  // Of samples that were taken: the reads' own, while `busy_`.
  std::uint64_t samples_ = 0;
  std::set<std::string> fingers_;

  std::mutex mutex_;  // guards what follows
  std::optional<grpc::Status> ending_;
  int busy_ = 0;  // threads that start a read or take a sample
  bool finished_ = false;
};

// All that are open. Thread-safe.
class FeedStreams {
 public:
  // False: closed already.
  bool Add(const std::shared_ptr<FeedStream>& stream);
  // Closes those there are and those to come.
  void Close();

 private:
  std::mutex mutex_;  // guards what follows
  std::vector<std::weak_ptr<FeedStream>> streams_;
  bool closed_ = false;
};

}  // namespace palpate
