// The calls of palpate.v1.Teleoperation. Those that watch are implemented in watch.cpp.
#pragma once

#include <atomic>
#include <cstdint>
#include <deque>
#include <functional>
#include <limits>
#include <memory>
#include <mutex>
#include <string>
#include <utility>

#include "palpate/v1/teleoperation.grpc.pb.h"

#include "shared/link/task_queue.h"
#include "slave/live/slave.h"
#include "slave/service/bulk_pace.h"
#include "slave/service/drive_stream.h"
#include "slave/service/exclusive_change.h"
#include "slave/service/feed_stream.h"
#include "slave/service/operate_stream.h"
#include "slave/service/operator_lease.h"
#include "slave/service/publisher.h"
#include "slave/service/stream_list.h"

namespace palpate {

// Calls that never wait run on gRPC's own threads, which cannot be used up: above all Stop, whose
// record is written by another thread. On a machine of two cores there are two of these threads.
// Operate, FeedTactile and DriveTool are reactors (see EndingStream). A change of the model may
// take long, a watcher mostly waits, and images are decoded: these are blocking handlers in a
// limited pool.
template <class Base>
using CalledBack =
    v1::Teleoperation::WithCallbackMethod_Stop<v1::Teleoperation::WithCallbackMethod_Reset<
        v1::Teleoperation::WithCallbackMethod_ReinitializeTracking<
            v1::Teleoperation::WithCallbackMethod_EvictOperator<
                v1::Teleoperation::WithCallbackMethod_GetStatus<
                    v1::Teleoperation::WithCallbackMethod_GetScene<
                        v1::Teleoperation::WithCallbackMethod_FeedTactile<
                            v1::Teleoperation::WithCallbackMethod_DriveTool<
                                v1::Teleoperation::WithCallbackMethod_Operate<Base>>>>>>>>>;

class TeleoperationService final : public CalledBack<v1::Teleoperation::Service> {
 public:
  // Streams of the Watch calls that may be open, and beyond them the operator's.
  static constexpr int kSeats = 64, kOperatorSeats = 8;
  static constexpr std::size_t kMaxEncoded = 8;  // encoded images that are kept for watchers
  // `slave` and `publisher` outlive the service.
  TeleoperationService(Slave& slave, Publisher& publisher, OperateStream::OnStream on_stream)
      : slave_(slave), publisher_(publisher), on_stream_(std::move(on_stream)) {}

  grpc::ServerUnaryReactor* GetScene(grpc::CallbackServerContext* context,
                                     const v1::GetSceneRequest* request,
                                     v1::SceneDescription* reply) override;
  grpc::ServerUnaryReactor* GetStatus(grpc::CallbackServerContext* context,
                                      const v1::GetStatusRequest* request,
                                      v1::Status* reply) override;
  grpc::ServerBidiReactor<v1::OperatorCommand, v1::SlaveState>* Operate(
      grpc::CallbackServerContext* context) override;
  grpc::Status WatchState(grpc::ServerContext* context, const v1::WatchStateRequest* request,
                          grpc::ServerWriter<v1::SlaveState>* writer) override;
  grpc::Status WatchTrace(grpc::ServerContext* context, const v1::WatchTraceRequest* request,
                          grpc::ServerWriter<v1::TraceUpdate>* writer) override;
  grpc::Status WatchMesh(grpc::ServerContext* context, const v1::WatchMeshRequest* request,
                         grpc::ServerWriter<v1::MeshState>* writer) override;
  grpc::Status WatchImages(grpc::ServerContext* context, const v1::WatchImagesRequest* request,
                           grpc::ServerWriter<v1::ImageState>* writer) override;
  grpc::Status WatchPatch(grpc::ServerContext* context, const v1::WatchPatchRequest* request,
                          grpc::ServerWriter<v1::PatchUpdate>* writer) override;
  grpc::Status SetModel(grpc::ServerContext* context, const v1::SetModelRequest* request,
                        v1::SettingsReply* reply) override;
  grpc::Status SetParameters(grpc::ServerContext* context, const v1::SetParametersRequest* request,
                             v1::SettingsReply* reply) override;
  grpc::ServerUnaryReactor* Reset(grpc::CallbackServerContext* context,
                                  const v1::ResetRequest* request, v1::Status* reply) override;
  grpc::ServerUnaryReactor* ReinitializeTracking(grpc::CallbackServerContext* context,
                                                 const v1::ReinitializeTrackingRequest* request,
                                                 v1::Status* reply) override;
  grpc::ServerUnaryReactor* EvictOperator(grpc::CallbackServerContext* context,
                                          const v1::EvictOperatorRequest* request,
                                          v1::Status* reply) override;
  grpc::ServerUnaryReactor* Stop(grpc::CallbackServerContext* context,
                                 const v1::StopRequest* request, v1::Status* reply) override;
  grpc::ServerReadReactor<v1::TactileSample>* FeedTactile(grpc::CallbackServerContext* context,
                                                          v1::FeedTactileReply* reply) override;
  grpc::ServerBidiReactor<v1::ArmReport, v1::ArmTarget>* DriveTool(
      grpc::CallbackServerContext* context) override;
  grpc::Status FeedImages(grpc::ServerContext* context, grpc::ServerReader<v1::ImageSample>* reader,
                          v1::FeedImagesReply* reply) override;
  grpc::Status ProposeScene(grpc::ServerContext* context, const v1::SceneProposal* request,
                            v1::ProposeSceneReply* reply) override;
  grpc::Status UseScene(grpc::ServerContext* context, const v1::SceneProposal* request,
                        v1::SceneDescription* reply) override;
  grpc::Status FindOutline(grpc::ServerContext* context, const v1::FindOutlineRequest* request,
                           v1::FindOutlineReply* reply) override;
  grpc::Status FindBoard(grpc::ServerContext* context, const v1::FindBoardRequest* request,
                         v1::FindBoardReply* reply) override;

  // Ends the streams that only listen; those that watch end with the publisher.
  void EndStreams() { feeds_.Close(), drives_.Close(); }

  // Fills a status for publishing to observers, in addition to the calls.
  void FillStatus(v1::Status* reply) const;
  // The newest image, at least as new as `sensed_at`: drawn and encoded once for all watchers with
  // the same options, one at a time, so that watchers use at most one core. Null: no image yet.
  std::shared_ptr<const EncodedImage> Encoded(Time sensed_at, bool overlays, int quality);
  BulkPace& bulk_pace() { return bulk_pace_; }

 private:
  // Runs `work` as a change of settings, if the slave has a set-up and no operator holds the lease.
  grpc::Status SetUp(grpc::ServerContext* context,
                     const std::function<void(SceneSetup&, Progress*)>& work);
  // Queues `work`, which may wait for the disk, and answers when it has run.
  grpc::ServerUnaryReactor* AnswerApart(grpc::CallbackServerContext* context,
                                        std::function<void()> work);
  // Throws RejectedCall unless the holder of the lease or an admin calls.
  void RequireOperator(const grpc::CallbackServerContext& context) const;
  // Runs a watcher's stream: reserves a thread of the pool, subscribes, streams and unsubscribes.
  // `prepare()` checks the request and returns the time between messages. `compose(state,
  // &message)` builds the message of a new state; it returns false if there is nothing to send.
  // `pace`: limits images and meshes; null: unlimited.
  template <class Message, class Prepare, class Compose>
  grpc::Status Watch(grpc::ServerContext* context, const Prepare& prepare, BulkPace* pace,
                     grpc::ServerWriter<Message>* writer, const Compose& compose);

  Slave& slave_;
  Publisher& publisher_;
  const OperateStream::OnStream on_stream_;
  BulkPace bulk_pace_;
  RefusedStreams refused_;
  OperatorLease lease_{
      slave_, OperatorLease::kSilence,
      [this](std::function<void()> task) {
        disk_calls_.Submit([task = std::move(task)](const std::stop_token& /*stop*/) { task(); });
      },
      [this](const auto& peer, double seconds) { bulk_pace_.AddRoundTrip(peer, seconds); }};
  ExclusiveChange change_;
  Seats seats_{kSeats, kOperatorSeats}, image_feeds_{4};  // one image feed is used
  FeedStreams feeds_;
  DriveStreams drives_;
  std::mutex encoding_;  // guards the next one
  struct CachedImage {
    bool overlays;
    int quality;
    std::shared_ptr<const EncodedImage> image;
  };
  std::deque<CachedImage> encoded_;            // of the newest sample, the newest first
  std::atomic<std::uint64_t> states_sent_{0};  // to all readers together
  // Records of stops and their resets, each limited by its call or by the lease. Last: its thread
  // uses all of the above.
  TaskQueue disk_calls_{std::numeric_limits<std::size_t>::max()};
};

}  // namespace palpate
