#include "master/device/spacemouse/spacemouse_source.h"

#include <algorithm>
#include <array>
#include <utility>

#include <poll.h>

namespace palpate {
namespace {

constexpr int kMotion = 1, kButton = 2, kDevice = 3;  // types of events
constexpr double kMotionLasts = 0.250;  // without an event: a deflected cap repeats them [s]
constexpr int kMostEvents = 64;         // taken per poll
constexpr double kDeadZone = 0.08;      // of the full deflection: the cap does not rest at zero [-]
constexpr std::size_t kMostButtons = 32;
const std::vector<UsbId> kUsbIds{{0x256f, 0}, {0x046d, 0xc603}, {0x046d, 0xc626}, {0x046d, 0xc62b}};

LibrarySearch SpnavSearch(std::vector<std::filesystem::path> folders) {
  return {{"libspnav.so.0", "libspnav.so"}, std::move(folders), false};
}

double WithoutDeadZone(double share) {
  const double beyond = std::abs(share) - kDeadZone;
  return beyond <= 0 ? 0 : std::copysign(std::min(beyond / (1 - kDeadZone), 1.0), share);
}

}  // namespace

std::string SpnavApi::Load(const LibrarySearch& search) {
  SharedLibrary library(search);
  library.Bind("spnav_open", &open);
  library.Bind("spnav_close", &close);
  library.Bind("spnav_fd", &fd);
  library.Bind("spnav_poll_event", &poll_event);
  library.BindOptional("spnav_dev_name", &device_name);
  return library.problem();
}

SpaceMouseSource::SpaceMouseSource(std::vector<std::filesystem::path> folders) {
  const std::string problem = api_.Load(SpnavSearch(std::move(folders)));
  if (!problem.empty()) throw DeviceUnavailable("spacemouse", problem);
  if (api_.open() == -1) {
    throw DeviceUnavailable("spacemouse", "spacenavd does not answer: is it running?");
  }
  std::array<char, 128> name{};
  const bool named = api_.device_name != nullptr &&
                     api_.device_name(name.data(), static_cast<int>(name.size()) - 1) > 0;
  description_ = "spacemouse: " + std::string(named ? name.data() : "unknown model");
}

SpaceMouseSource::~SpaceMouseSource() {
  api_.close();
}

RateInput SpaceMouseSource::Poll(Time now) {
  pollfd line{api_.fd(), POLLIN, 0};
  if (line.fd < 0 || (poll(&line, 1, 0) > 0 && (line.revents & ~POLLIN) != 0)) gone_ = true;
  SpnavEvent event{};
  for (int i = 0; !gone_ && i < kMostEvents && api_.poll_event(&event) != 0; ++i) Take(event, now);
  if (SecondsBetween(moved_at_, now) > kMotionLasts) counts_.setZero();
  RateInput input;
  for (int i = 0; i < 3; ++i) input.share[i] = WithoutDeadZone(counts_[i] / full_scale_);
  input.buttons = buttons_;
  input.engaged = (buttons_ & 1U) != 0;
  if (gone_ || unplugged_) {
    input.fault = DeviceFault::kUnplugged;
    input.cause = gone_ ? "spacenavd has closed the connection" : "spacenavd reports its removal";
  }
  return input;
}

// The library's z points away from the operator.
void SpaceMouseSource::Take(const SpnavEvent& event, Time now) {
  if (event.type == kMotion) {
    const auto& motion = event.motion;
    counts_ = Eigen::Vector3d(motion.x, motion.y, -motion.z);
    moved_at_ = now;
    full_scale_ = std::max(full_scale_, counts_.cwiseAbs().maxCoeff());
  } else if (event.type == kDevice) {
    unplugged_ = event.device.removed != 0;
    counts_.setZero();
    buttons_ = 0;
  } else if (event.type == kButton) {
    auto known = std::ranges::find(known_buttons_, event.button.number);
    if (known == known_buttons_.end()) {
      if (known_buttons_.size() >= kMostButtons) return;
      known_buttons_.push_back(event.button.number);
      known = known_buttons_.end() - 1;
    }
    const auto bit = std::uint32_t{1} << static_cast<unsigned>(known - known_buttons_.begin());
    buttons_ = event.button.press != 0 ? buttons_ | bit : buttons_ & ~bit;
  }
}

Driver SpaceMouseDriver() {
  return {"spacemouse", "3Dconnexion SpaceMouse (libspnav, spacenavd), without force",
          "speed in mm/s, 20 by default",
          [] {
            DriverReport report;
            const LibrarySearch search = SpnavSearch({});
            AddLibrary(search, SharedLibrary(search), &report);
            report.searched.emplace_back("USB 256f, 046d (3Dconnexion)");
            for (const DeviceNode& node : FindUsb(kUsbIds)) {
              report.found.push_back(node.name + " at " + node.node.string());
            }
            if (report.missing.empty()) AddOpened(SpaceMouseDriver(), &report);
            if (!report.missing.empty()) {
              report.next =
                  "sudo apt-get install libspnav0 spacenavd; sudo systemctl start spacenavd";
            }
            return report;
          },
          [](const std::string& option) -> std::unique_ptr<HapticDevice> {
            const double speed = SpeedOf("spacemouse", option);
            return std::make_unique<RateDevice>(
                std::make_unique<SpaceMouseSource>(std::vector<std::filesystem::path>()), speed);
          }};
}

}  // namespace palpate
