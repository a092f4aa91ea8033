// Texts for failed calls. Messages of gRPC about the connection are replaced by clear ones.
#pragma once

#include <string>

#include <grpcpp/support/status.h>

namespace palpate {

// The reason of `status`: at most 300 printable characters, because the peer may be malicious. A
// message of the slave itself is kept; empty without one.
std::string WordsOf(const grpc::Status& status);

}  // namespace palpate
