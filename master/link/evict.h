// The command of an administrator.
#pragma once

#include <string>

#include "master/link/slave_link.h"

namespace palpate {

// Ends the lease of the slave's operator because of `reason`, and returns the operator's name.
// Throws std::runtime_error: no answer within `link.wait`, no operator, or not permitted.
std::string EvictOperator(const SlaveLink::Options& link, const std::string& reason);

}  // namespace palpate
