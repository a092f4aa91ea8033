// `palpate-master devices`: what each driver searched, found and misses, and what to do.
#pragma once

#include <string>

#include "master/device/search/driver.h"

namespace palpate {

// Text of one driver, with line ends.
std::string InWords(const Driver& driver, const DriverReport& report);

// Prints the reports of all drivers. Returns 0. Opens what it finds and reads it, without a force.
int ListDevices();

}  // namespace palpate
