// SetModel, SetParameters, Reset, Stop.
#include "slave/service/describe.h"
#include "slave/service/requests.h"
#include "slave/service/status.h"
#include "slave/service/teleoperation_service.h"

namespace palpate {
namespace {

constexpr std::size_t kLongestReason = 200;  // [bytes]; what is longer is cut, never refused

}  // namespace

grpc::Status TeleoperationService::SetModel(grpc::ServerContext* /*context*/,
                                            const v1::SetModelRequest* request,
                                            v1::SettingsReply* reply) {
  return Guarded([&] {
    slave_.SetModel(ToChange(*request));
    ToProto(slave_.Describe(), reply->mutable_scene());
  });
}

grpc::Status TeleoperationService::SetParameters(grpc::ServerContext* /*context*/,
                                                 const v1::SetParametersRequest* request,
                                                 v1::SettingsReply* reply) {
  return Guarded([&] {
    slave_.SetParameters(ToChange(*request));
    ToProto(slave_.Describe(), reply->mutable_scene());
  });
}

grpc::Status TeleoperationService::Reset(grpc::ServerContext* /*context*/,
                                         const v1::ResetRequest* /*request*/, v1::Status* reply) {
  return Guarded([&] {
    slave_.Reset();
    FillStatus(reply);
  });
}

grpc::Status TeleoperationService::Stop(grpc::ServerContext* /*context*/,
                                        const v1::StopRequest* request, v1::Status* reply) {
  return Guarded([&] {
    slave_.EmergencyStop(request->reason().substr(0, kLongestReason));
    FillStatus(reply);
  });
}

}  // namespace palpate
