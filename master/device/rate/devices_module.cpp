// The module palpate-devices.so: see rate_drivers.h.
#include <exception>
#include <memory>

#include "master/device/gamepad/gamepad_source.h"
#include "master/device/search/driver.h"
#include "master/device/spacemouse/spacemouse_source.h"

namespace palpate {
namespace {

template <class Source>
RateSource* Opened(std::string* problem) {
  try {
    return std::make_unique<Source>().release();
  } catch (const DeviceUnavailable& error) {
    *problem = error.reason();
  }
  return nullptr;
}

}  // namespace
}  // namespace palpate

extern "C" palpate::RateSource* palpate_open_gamepad(std::string* problem) {
  return palpate::Opened<palpate::GamepadSource>(problem);
}

extern "C" palpate::RateSource* palpate_open_spacemouse(std::string* problem) {
  return palpate::Opened<palpate::SpaceMouseSource>(problem);
}
