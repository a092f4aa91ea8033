// GetScene, GetStatus, GetCapabilities.
#include "slave/service/describe.h"
#include "slave/service/status.h"
#include "slave/service/teleoperation_service.h"

namespace palpate {

grpc::Status TeleoperationService::GetScene(grpc::ServerContext* /*context*/,
                                            const v1::GetSceneRequest* /*request*/,
                                            v1::SceneDescription* reply) {
  return Guarded([&] { ToProto(slave_.Describe(), reply); });
}

grpc::Status TeleoperationService::GetStatus(grpc::ServerContext* /*context*/,
                                             const v1::GetStatusRequest* /*request*/,
                                             v1::Status* reply) {
  return Guarded([&] { FillStatus(reply); });
}

grpc::Status TeleoperationService::GetCapabilities(grpc::ServerContext* /*context*/,
                                                   const v1::GetCapabilitiesRequest* /*request*/,
                                                   v1::Capabilities* reply) {
  return Guarded([&] { ToProto(slave_.Describe(), reply); });
}

void TeleoperationService::FillStatus(v1::Status* reply) const {
  ToProto(slave_.Status(), reply);
  reply->set_operator_name(lease_.holder_name());
  reply->set_observers(static_cast<std::uint32_t>(seats_.taken()));
  reply->set_states(states_sent_);
  // What cannot even be read never reaches the slave, but came and was refused all the same.
  const std::uint64_t malformed = lease_.malformed();
  reply->set_commands(reply->commands() + malformed);
  reply->set_commands_refused(reply->commands_refused() + malformed);
}

}  // namespace palpate
