// FeedTactile.
#include "slave/service/teleoperation_service.h"

namespace palpate {

grpc::ServerReadReactor<v1::TactileSample>* TeleoperationService::FeedTactile(
    grpc::CallbackServerContext* /*context*/, v1::FeedTactileReply* reply) {
  return FeedStream::Open(slave_.tactile_inbox(), &feeds_, reply);
}

}  // namespace palpate
