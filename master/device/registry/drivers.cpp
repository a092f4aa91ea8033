#include "master/device/registry/drivers.h"

#include <array>

#include "master/device/dhd/dhd_device.h"
#include "master/device/haply/haply_device.h"
#include "master/device/spacemouse/spacemouse.h"
#include "master/device/touch/touch_device.h"

namespace palpate {

std::span<const Driver> Drivers() {
  static const std::array drivers{TouchDriver(), DhdDriver(), HaplyDriver(), SpaceMouseDriver()};
  return drivers;
}

}  // namespace palpate
