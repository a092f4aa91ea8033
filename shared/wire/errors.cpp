#include "shared/wire/errors.h"

#include <array>

namespace palpate {
namespace {

constexpr const char* kInfoType = "type.googleapis.com/google.rpc.ErrorInfo";
constexpr const char* kDomain = "palpate.v1";
constexpr std::string_view kPrefix = "ERROR_REASON_";

// The status code of each reason, as errors.proto documents it.
constexpr std::array<grpc::StatusCode, v1::ErrorReason_MAX + 1> kCodes{
    grpc::StatusCode::UNKNOWN,
    grpc::StatusCode::INVALID_ARGUMENT,
    grpc::StatusCode::FAILED_PRECONDITION,
    grpc::StatusCode::ABORTED,
    grpc::StatusCode::FAILED_PRECONDITION,
    grpc::StatusCode::FAILED_PRECONDITION,
    grpc::StatusCode::ABORTED,
    grpc::StatusCode::FAILED_PRECONDITION,
    grpc::StatusCode::FAILED_PRECONDITION,
    grpc::StatusCode::FAILED_PRECONDITION,
    grpc::StatusCode::RESOURCE_EXHAUSTED,
    grpc::StatusCode::UNAUTHENTICATED,
    grpc::StatusCode::PERMISSION_DENIED,
    grpc::StatusCode::UNAVAILABLE,
    grpc::StatusCode::CANCELLED,
    grpc::StatusCode::INTERNAL,
    grpc::StatusCode::FAILED_PRECONDITION,
    grpc::StatusCode::FAILED_PRECONDITION,
    grpc::StatusCode::UNAVAILABLE};

}  // namespace

grpc::Status Error(v1::ErrorReason reason, const std::string& message) {
  const grpc::StatusCode code = kCodes[static_cast<std::size_t>(reason)];
  v1::ErrorInfo info;
  info.set_reason(v1::ErrorReason_Name(reason).substr(kPrefix.size()));
  info.set_domain(kDomain);
  v1::ErrorStatus status;
  status.set_code(code);
  status.set_message(message);
  auto* detail = status.add_details();
  detail->set_type_url(kInfoType);
  detail->set_value(info.SerializeAsString());
  return {code, message, status.SerializeAsString()};
}

v1::ErrorReason ReasonOf(const grpc::Status& status) {
  v1::ErrorStatus details;
  v1::ErrorInfo info;
  v1::ErrorReason reason = v1::ERROR_REASON_UNSPECIFIED;
  if (!details.ParseFromString(status.error_details())) return reason;
  for (const auto& detail : details.details()) {
    if (detail.type_url() != kInfoType || !info.ParseFromString(detail.value())) continue;
    if (info.domain() != kDomain) continue;
    v1::ErrorReason_Parse(std::string(kPrefix) + info.reason(), &reason);
  }
  return reason;
}

}  // namespace palpate
