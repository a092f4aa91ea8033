// The drivers of real devices. None needs its vendor's software until it is opened.
#pragma once

#include <span>

#include "master/device/search/driver.h"

namespace palpate {

std::span<const Driver> Drivers();

}  // namespace palpate
