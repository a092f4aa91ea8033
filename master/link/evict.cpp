#include "master/link/evict.h"

#include <chrono>
#include <stdexcept>

#include "palpate/v1/teleoperation.grpc.pb.h"

#include "master/link/channel.h"
#include "master/link/status_words.h"

namespace palpate {

std::string EvictOperator(const SlaveLink::Options& link, const std::string& reason) {
  const auto target = PermittedTarget(link.target, link.insecure || !link.tls.empty());
  const auto stub = v1::Teleoperation::NewStub(OpenChannel(target, Traffic::kTicks, link.tls));
  const auto deadline = std::chrono::system_clock::now() +
                        std::chrono::milliseconds(static_cast<int>(1000 * link.wait));
  const auto require = [](const grpc::Status& status) {
    if (!status.ok()) throw std::runtime_error(WordsOf(status));
  };
  grpc::ClientContext first, second;
  first.set_deadline(deadline);
  first.set_wait_for_ready(true);
  second.set_deadline(deadline);
  v1::Status status, after;
  require(stub->GetStatus(&first, {}, &status));
  v1::EvictOperatorRequest request;
  request.set_reason(reason);
  require(stub->EvictOperator(&second, request, &after));
  return status.operator_name();
}

}  // namespace palpate
