// The drivers of devices without force. Their libraries, SDL2 and libspnav, are linked by the
// module palpate-devices.so alone, which is loaded when such a device is opened.
#pragma once

#include "master/device/search/driver.h"

namespace palpate {

// Rows of the table of drivers.
Driver SpaceMouseDriver();
Driver GamepadDriver();

}  // namespace palpate
