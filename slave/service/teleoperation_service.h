// The calls of palpate.v1.Teleoperation. Those that watch are implemented in watch.cpp.
#pragma once

#include <atomic>
#include <cstdint>

#include "palpate/v1/teleoperation.grpc.pb.h"

#include "slave/pipeline/teleop/slave.h"
#include "slave/service/feed_stream.h"
#include "slave/service/operate_stream.h"
#include "slave/service/operator_lease.h"
#include "slave/service/publisher.h"

namespace palpate {

// Operate and FeedTactile are reactors (see EndingStream); everything else is a blocking handler,
// since a change of the model may take a while and a watcher mostly waits.
class TeleoperationService final
    : public v1::Teleoperation::WithCallbackMethod_FeedTactile<
          v1::Teleoperation::WithCallbackMethod_Operate<v1::Teleoperation::Service>> {
 public:
  // `slave` and `publisher` outlive the service.
  TeleoperationService(Slave& slave, Publisher& publisher)
      : slave_(slave), publisher_(publisher), lease_(slave) {}

  grpc::Status GetScene(grpc::ServerContext* context, const v1::GetSceneRequest* request,
                        v1::SceneDescription* reply) override;
  grpc::Status GetStatus(grpc::ServerContext* context, const v1::GetStatusRequest* request,
                         v1::Status* reply) override;
  grpc::Status GetCapabilities(grpc::ServerContext* context,
                               const v1::GetCapabilitiesRequest* request,
                               v1::Capabilities* reply) override;
  grpc::ServerBidiReactor<v1::OperatorCommand, v1::SlaveState>* Operate(
      grpc::CallbackServerContext* context) override;
  grpc::Status WatchState(grpc::ServerContext* context, const v1::WatchStateRequest* request,
                          grpc::ServerWriter<v1::SlaveState>* writer) override;
  grpc::Status WatchMesh(grpc::ServerContext* context, const v1::WatchMeshRequest* request,
                         grpc::ServerWriter<v1::MeshState>* writer) override;
  grpc::Status WatchVideo(grpc::ServerContext* context, const v1::WatchVideoRequest* request,
                          grpc::ServerWriter<v1::VideoFrame>* writer) override;
  grpc::Status SetModel(grpc::ServerContext* context, const v1::SetModelRequest* request,
                        v1::SettingsReply* reply) override;
  grpc::Status SetParameters(grpc::ServerContext* context, const v1::SetParametersRequest* request,
                             v1::SettingsReply* reply) override;
  grpc::Status Reset(grpc::ServerContext* context, const v1::ResetRequest* request,
                     v1::Status* reply) override;
  grpc::Status Stop(grpc::ServerContext* context, const v1::StopRequest* request,
                    v1::Status* reply) override;
  grpc::ServerReadReactor<v1::TactileSample>* FeedTactile(grpc::CallbackServerContext* context,
                                                          v1::FeedTactileReply* reply) override;

  // Ends the streams that only listen; those that watch end with the publisher.
  void Stop() { feeds_.Close(); }

 private:
  void FillStatus(v1::Status* reply) const;
  // What a watcher's stream does once its request is accepted: take a seat, subscribe, stream,
  // leave. `compose(state, &message)` makes the message of a new state; false: nothing to be sent.
  template <class Message, class Compose>
  grpc::Status Watch(grpc::ServerContext* context, Clock::duration gap,
                     grpc::ServerWriter<Message>* writer, const Compose& compose);

  Slave& slave_;
  Publisher& publisher_;
  OperatorLease lease_;
  ObserverSeats seats_;
  FeedStreams feeds_;
  std::atomic<std::uint64_t> states_sent_{0};  // to all readers together
};

}  // namespace palpate
