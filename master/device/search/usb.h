// Devices that the kernel lists, whether or not a driver of theirs is installed: USB, HID and
// serial nodes, and who may open them.
#pragma once

#include <cstdint>
#include <filesystem>
#include <string>
#include <vector>

namespace palpate {

struct UsbId {
  std::uint16_t vendor = 0;
  std::uint16_t product = 0;  // 0: any
};

// A node that belongs to a device.
struct DeviceNode {
  std::string name;            // as the device calls itself
  std::filesystem::path node;  // such as /dev/hidraw3
  bool accessible = false;     // this user may read and write it
};

// USB devices of one of `ids`, their /dev/bus/usb nodes.
std::vector<DeviceNode> FindUsb(const std::vector<UsbId>& ids);
// Raw HID nodes of one of `ids`.
std::vector<DeviceNode> FindHid(const std::vector<UsbId>& ids);
// Serial USB nodes (/dev/ttyACM*) of one of `ids`.
std::vector<DeviceNode> FindSerial(const std::vector<UsbId>& ids);
// Names of network interfaces with a link-local address (169.254.x.x), which Ethernet devices use.
std::vector<std::string> LinkLocalInterfaces();

}  // namespace palpate
