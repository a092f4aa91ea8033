// Errors of calls: a status with a reason for programs and a sentence for people. See errors.proto.
#pragma once

#include <string>

#include <grpcpp/support/status.h>

#include "palpate/v1/errors.pb.h"

namespace palpate {

// Returns a status with the code of `reason`. `message` states what is wrong and what is accepted.
grpc::Status Error(v1::ErrorReason reason, const std::string& message);

// The reason of `status`. ERROR_REASON_UNSPECIFIED: it has none, or one that is not known here.
v1::ErrorReason ReasonOf(const grpc::Status& status);

}  // namespace palpate
