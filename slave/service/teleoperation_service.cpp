#include "slave/service/teleoperation_service.h"

#include "shared/link/thread_priority.h"
#include "shared/text/text.h"
#include "slave/service/messages.h"
#include "slave/service/roles.h"
#include "slave/service/status.h"

namespace palpate {
namespace {

// Tactile samples need 80 kB/s; 4000 reports have 128 bytes each. [bytes/s]
constexpr double kSampleRate = 256e3, kReportRate = 512e3;
// [characters]; longer reasons are truncated, not rejected.
constexpr std::size_t kMaxReasonLength = 200;

// Answers with the result of `work`.
template <class Work>
grpc::ServerUnaryReactor* Answer(grpc::CallbackServerContext* context, const Work& work) {
  grpc::ServerUnaryReactor* const reactor = context->DefaultReactor();
  reactor->Finish(Guarded(work));
  return reactor;
}

}  // namespace

grpc::ServerUnaryReactor* TeleoperationService::GetScene(grpc::CallbackServerContext* context,
                                                         const v1::GetSceneRequest* /*request*/,
                                                         v1::SceneDescription* reply) {
  return Answer(context, [&] { ToProto(slave_.Describe(), reply); });
}

grpc::ServerUnaryReactor* TeleoperationService::GetStatus(grpc::CallbackServerContext* context,
                                                          const v1::GetStatusRequest* /*request*/,
                                                          v1::Status* reply) {
  return Answer(context, [&] { FillStatus(reply); });
}

void TeleoperationService::FillStatus(v1::Status* reply) const {
  ToProto(slave_.Status(), reply);
  reply->set_operator_name(lease_.holder_name());
  reply->set_observers(static_cast<std::uint32_t>(seats_.taken()));
  reply->set_states(states_sent_);
  // Unreadable commands never reach the slave, but they count as received and refused.
  const std::uint64_t malformed = lease_.malformed();
  reply->set_commands(reply->commands() + malformed);
  reply->set_commands_refused(reply->commands_refused() + malformed);
  refused_.FillStatus(reply);
}

grpc::Status TeleoperationService::SetModel(grpc::ServerContext* context,
                                            const v1::SetModelRequest* request,
                                            v1::SettingsReply* reply) {
  return change_.Run(*context, [&](Progress* progress) {
    lease_.RefuseOthers(context->peer());
    slave_.SetModel(ToChange(*request), progress);
    ToProto(slave_.Describe(), reply->mutable_scene());
  });
}

grpc::Status TeleoperationService::SetParameters(grpc::ServerContext* context,
                                                 const v1::SetParametersRequest* request,
                                                 v1::SettingsReply* reply) {
  return change_.Run(*context, [&](Progress* progress) {
    lease_.RefuseOthers(context->peer());
    slave_.SetParameters(ToChange(*request), progress);
    ToProto(slave_.Describe(), reply->mutable_scene());
  });
}

grpc::ServerUnaryReactor* TeleoperationService::AnswerApart(grpc::CallbackServerContext* context,
                                                            std::function<void()> work) {
  grpc::ServerUnaryReactor* const reactor = context->DefaultReactor();
  disk_calls_.Submit([reactor, work = std::move(work)](const std::stop_token& /*stop*/) {
    const grpc::Status status = Guarded(work);
    const ReadingPriority calls_grpc;
    reactor->Finish(status);
  });
  return reactor;
}

void TeleoperationService::RequireOperator(const grpc::CallbackServerContext& context) const {
  if (IdentityOf(*context.auth_context()).role != "admin") lease_.RefuseOthers(context.peer());
}

grpc::ServerUnaryReactor* TeleoperationService::Reset(grpc::CallbackServerContext* context,
                                                      const v1::ResetRequest* request,
                                                      v1::Status* reply) {
  // Without certificates there are no roles, and every client may do everything.
  const bool is_operator = IdentityOf(*context->auth_context()).role == "operator";
  return AnswerApart(context, [this, is_operator, context, request, reply] {
    RequireOperator(*context);
    if (is_operator && slave_.Status().phase == Phase::kEstop) {
      lease_.RequireHeldBy(context->peer(), "an emergency stop can be cleared");
    }
    slave_.Reset(request->stops());
    FillStatus(reply);
  });
}

grpc::ServerUnaryReactor* TeleoperationService::ReinitializeTracking(
    grpc::CallbackServerContext* context, const v1::ReinitializeTrackingRequest* /*request*/,
    v1::Status* reply) {
  return Answer(context, [&] {
    RequireOperator(*context);
    slave_.ReinitializeTracking();
    FillStatus(reply);
  });
}

grpc::ServerUnaryReactor* TeleoperationService::EvictOperator(
    grpc::CallbackServerContext* context, const v1::EvictOperatorRequest* request,
    v1::Status* reply) {
  return Answer(context, [&] {
    lease_.Evict(Presentable(request->reason(), kMaxReasonLength));
    FillStatus(reply);
  });
}

grpc::ServerUnaryReactor* TeleoperationService::Stop(grpc::CallbackServerContext* context,
                                                     const v1::StopRequest* request,
                                                     v1::Status* reply) {
  slave_.StopTool();
  return AnswerApart(context, [this, request, reply] {
    slave_.RecordStop(Presentable(request->reason(), kMaxReasonLength));
    FillStatus(reply);
  });
}

grpc::ServerBidiReactor<v1::OperatorCommand, v1::SlaveState>* TeleoperationService::Operate(
    grpc::CallbackServerContext* context) {
  return OperateStream::Open({lease_, publisher_, states_sent_, refused_, on_stream_}, *context);
}

grpc::ServerReadReactor<v1::TactileSample>* TeleoperationService::FeedTactile(
    grpc::CallbackServerContext* context, v1::FeedTactileReply* reply) {
  on_stream_(*context, slave_.tactile_inbox() != nullptr ? kSampleRate : 0);
  return FeedStream::Open(slave_.tactile_inbox(), &feeds_, reply);
}

grpc::ServerBidiReactor<v1::ArmReport, v1::ArmTarget>* TeleoperationService::DriveTool(
    grpc::CallbackServerContext* context) {
  on_stream_(*context, slave_.driven_arm() != nullptr ? kReportRate : 0);
  return DriveStream::Open(slave_.driven_arm(), &drives_);
}

}  // namespace palpate
