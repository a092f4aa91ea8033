// Why a call failed, for people: what gRPC itself says of lines in words that tell what is the
// case.
#pragma once

#include <string>

#include <grpcpp/support/status.h>

namespace palpate {

// Of a peer that may mean harm, fit for a terminal: at most 300 characters. What the slave says
// itself stays as it said it; empty: it said nothing.
std::string WordsOf(const grpc::Status& status);

}  // namespace palpate
