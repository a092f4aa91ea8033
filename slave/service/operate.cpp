// Operate.
#include "slave/service/teleoperation_service.h"

namespace palpate {

grpc::ServerBidiReactor<v1::OperatorCommand, v1::SlaveState>* TeleoperationService::Operate(
    grpc::CallbackServerContext* context) {
  return OperateStream::Open({lease_, publisher_, states_sent_}, context->peer());
}

}  // namespace palpate
