// `palpate-master devices`: reports for each driver which libraries and devices it searched, found
// and lacks, with advice.
#pragma once

#include <string>

#include "master/device/search/driver.h"

namespace palpate {

// Text of one driver, with line ends.
std::string InWords(const Driver& driver, const DriverReport& report);

// Opens each device that is found, reads it without a force, and prints the reports of all drivers.
// Returns 0.
int ListDevices();

}  // namespace palpate
