// Whether an address can be listened on, asked of the operating system: gRPC only says that it
// failed.
#pragma once

#include "shared/link/loopback.h"

namespace palpate {

// Throws std::runtime_error: host unknown, port in use, not an address of this machine, not
// permitted.
void RequireListenable(const Endpoint& endpoint);

}  // namespace palpate
