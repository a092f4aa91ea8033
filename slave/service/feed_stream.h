// A driver's stream of tactile samples.
#pragma once

#include <cstdint>
#include <memory>
#include <set>
#include <string>

#include <grpcpp/support/server_callback.h>

#include "palpate/v1/state.pb.h"
#include "palpate/v1/teleoperation.pb.h"

#include "slave/capture/tactile_inbox.h"
#include "slave/service/status.h"
#include "slave/service/stream_list.h"

namespace palpate {

class FeedStream;
using FeedStreams = StreamList<FeedStream>;

class FeedStream final : public EndingStream<grpc::ServerReadReactor<v1::TactileSample>> {
 public:
  // `inbox` outlives the stream; null: the stream is refused. `reply` is gRPC's, until OnDone.
  static grpc::ServerReadReactor<v1::TactileSample>* Open(TactileInbox* inbox, FeedStreams* streams,
                                                          v1::FeedTactileReply* reply);

  // The slave is stopping.
  void Close() { End(Stopping()); }

  void OnReadDone(bool ok) override;

 private:
  FeedStream(TactileInbox* inbox, v1::FeedTactileReply* reply);

  // The first sentence to report about this sample; empty: it was accepted.
  std::string Feed();
  void OnQuiet() override;

  TactileInbox* const inbox_;
  const TactileInbox::SenderId sender_;
  v1::FeedTactileReply* const reply_;
  v1::TactileSample sample_;  // gRPC's while a read is waiting
  // Number of accepted samples, used by the reading thread while `busy_`.
  std::uint64_t samples_ = 0;
  std::set<std::string> fingers_;
};

}  // namespace palpate
