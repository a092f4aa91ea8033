#include "master/device/search/usb.h"

#include <algorithm>
#include <charconv>
#include <fstream>
#include <optional>

#include <arpa/inet.h>
#include <ifaddrs.h>
#include <unistd.h>

#include "shared/text/text.h"

namespace palpate {
namespace {

namespace fs = std::filesystem;

std::string FirstLine(const fs::path& file) {
  std::string line;
  std::ifstream in(file);
  std::getline(in, line);
  return line;
}

std::optional<std::uint32_t> Hex(std::string_view text) {
  std::uint32_t value = 0;
  const auto [end, error] = std::from_chars(text.data(), text.data() + text.size(), value, 16);
  if (error != std::errc() || end != text.data() + text.size() || text.empty()) return std::nullopt;
  return value;
}

bool IsOneOf(const std::vector<UsbId>& ids, std::uint32_t vendor, std::uint32_t product) {
  return std::ranges::any_of(ids, [&](const UsbId& id) {
    return id.vendor == vendor && (id.product == 0 || id.product == product);
  });
}

// Whether the USB device of the folder `at` has one of `ids`.
bool HasId(const fs::path& at, const std::vector<UsbId>& ids) {
  const auto vendor = Hex(FirstLine(at / "idVendor")), product = Hex(FirstLine(at / "idProduct"));
  return vendor && product && IsOneOf(ids, *vendor, *product);
}

DeviceNode NodeOf(std::string name, fs::path node) {
  const bool accessible = access(node.c_str(), R_OK | W_OK) == 0;
  return {Presentable(name, 60), std::move(node), accessible};
}

// Entries of a folder of /sys, sorted; none where it cannot be read.
std::vector<fs::path> Entries(const fs::path& folder) {
  std::error_code error;
  std::vector<fs::path> found;
  for (const auto& entry : fs::directory_iterator(folder, error)) found.push_back(entry.path());
  std::ranges::sort(found);
  return found;
}

// Vendor and product of a line such as HID_ID=0003:00002988:00000302.
bool HidHasId(const fs::path& uevent, const std::vector<UsbId>& ids, std::string* name) {
  std::ifstream in(uevent);
  bool found = false;
  for (std::string line; std::getline(in, line);) {
    if (line.starts_with("HID_NAME=")) *name = line.substr(9);
    if (!line.starts_with("HID_ID=") || line.size() < 29) continue;
    const auto vendor = Hex(std::string_view(line).substr(12, 8));
    const auto product = Hex(std::string_view(line).substr(21, 8));
    found = vendor && product && IsOneOf(ids, *vendor, *product);
  }
  return found;
}

}  // namespace

std::vector<DeviceNode> FindUsb(const std::vector<UsbId>& ids) {
  std::vector<DeviceNode> found;
  for (const fs::path& at : Entries("/sys/bus/usb/devices")) {
    if (!HasId(at, ids)) continue;
    const double bus = ParseFinite(FirstLine(at / "busnum")).value_or(0);
    const double number = ParseFinite(FirstLine(at / "devnum")).value_or(0);
    found.push_back(
        NodeOf(FirstLine(at / "product"), Formatted("/dev/bus/usb/%03.0f/%03.0f", bus, number)));
  }
  return found;
}

std::vector<DeviceNode> FindHid(const std::vector<UsbId>& ids) {
  std::vector<DeviceNode> found;
  for (const fs::path& at : Entries("/sys/class/hidraw")) {
    std::string name;
    if (!HidHasId(at / "device/uevent", ids, &name)) continue;
    found.push_back(NodeOf(name, "/dev" / at.filename()));
  }
  return found;
}

std::vector<DeviceNode> FindSerial(const std::vector<UsbId>& ids) {
  std::vector<DeviceNode> found;
  for (const fs::path& at : Entries("/sys/class/tty")) {
    if (!at.filename().string().starts_with("ttyACM")) continue;
    std::error_code error;
    const fs::path usb = fs::canonical(at / "device", error).parent_path();
    if (error || !HasId(usb, ids)) continue;
    found.push_back(NodeOf(FirstLine(usb / "product"), "/dev" / at.filename()));
  }
  return found;
}

std::vector<std::string> LinkLocalInterfaces() {
  constexpr std::uint32_t kMask = 0xffff0000, kLinkLocal = 0xa9fe0000;  // 169.254.0.0/16
  std::vector<std::string> found;
  ifaddrs* all = nullptr;
  if (getifaddrs(&all) != 0) return found;
  for (const ifaddrs* one = all; one != nullptr; one = one->ifa_next) {
    if (one->ifa_addr == nullptr || one->ifa_addr->sa_family != AF_INET) continue;
    const auto* address = reinterpret_cast<const sockaddr_in*>(one->ifa_addr);
    if ((ntohl(address->sin_addr.s_addr) & kMask) == kLinkLocal) found.emplace_back(one->ifa_name);
  }
  freeifaddrs(all);
  return found;
}

}  // namespace palpate
