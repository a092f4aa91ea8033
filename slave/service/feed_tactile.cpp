// FeedTactile: no scene has a tactile sensor yet.
#include "slave/service/teleoperation_service.h"

namespace palpate {

grpc::Status TeleoperationService::FeedTactile(grpc::ServerContext* /*context*/,
                                               grpc::ServerReader<v1::TactileSample>* /*reader*/,
                                               v1::FeedTactileReply* /*reply*/) {
  return {grpc::StatusCode::FAILED_PRECONDITION, "the scene has no tactile sensor"};
}

}  // namespace palpate
