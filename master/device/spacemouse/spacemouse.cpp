#include "master/device/spacemouse/spacemouse.h"

#include <algorithm>
#include <array>
#include <chrono>
#include <cmath>
#include <stdexcept>

#include <poll.h>

#include "shared/text/text.h"

namespace palpate {
namespace {

constexpr auto kPollEvery = std::chrono::milliseconds(5);
constexpr double kMaxStep = 0.1;        // longest simulated time between readings [s]
constexpr double kMotionLasts = 0.250;  // without an event: a deflected cap repeats them [s]
constexpr int kMaxEvents = 64;          // taken per poll
constexpr double kDeadZone = 0.08;      // of the full deflection: the cap does not rest at zero [-]
constexpr std::size_t kMaxButtons = 32;
constexpr double kUsual = 20, kSlowest = 0.1, kFastest = 200;  // [mm/s]

LibrarySearch SpnavSearch() {
  return {{"libspnav.so.0", "libspnav.so"}, {}, false};
}

double WithoutDeadZone(double share) {
  const double beyond = std::abs(share) - kDeadZone;
  return beyond <= 0 ? 0 : std::copysign(std::min(beyond / (1 - kDeadZone), 1.0), share);
}

// The speed in m/s that `option` gives in mm/s.
double SpeedOf(const std::string& option) {
  if (option.empty()) return 1e-3 * kUsual;
  const auto speed = ParseFinite(option);
  if (speed && *speed >= kSlowest && *speed <= kFastest) return 1e-3 * *speed;
  throw std::invalid_argument("--device spacemouse:" + option +
                              ": expected the speed at full deflection, 0.1 to 200 mm/s");
}

}  // namespace

std::string SpnavApi::Load() {
  SharedLibrary library(SpnavSearch());
  library.Bind("spnav_open", &open);
  library.Bind("spnav_close", &close);
  library.Bind("spnav_fd", &descriptor);
  library.Bind("spnav_poll_event", &poll_event);
  library.BindOptional("spnav_dev_name", &device_name);
  return library.problem();
}

SpaceMouse::SpaceMouse(double speed, bool polls)
    : HapticDevice(CapabilitiesOfArm()), speed_(speed), hand_(Arm()) {
  RequirePositive("speed", speed);
  const std::string problem = api_.Load();
  if (!problem.empty()) throw DeviceUnavailable("spacemouse", problem);
  if (api_.open() == -1) {
    throw DeviceUnavailable("spacemouse", "spacenavd does not answer: is it running?");
  }
  std::array<char, 128> name{};
  const bool named = api_.device_name != nullptr &&
                     api_.device_name(name.data(), static_cast<int>(name.size()) - 1) > 0;
  description_ = "spacemouse: " + std::string(named ? name.data() : "unknown model") +
                 Formatted(", up to %g mm/s", 1e3 * speed);
  if (!polls) return;
  thread_ = std::jthread([this](const std::stop_token& stop) {
    while (!stop.stop_requested()) {
      Poll(Clock::now());
      std::this_thread::sleep_for(kPollEvery);
    }
  });
}

SpaceMouse::~SpaceMouse() {
  if (thread_.joinable()) {
    thread_.request_stop();
    thread_.join();
  }
  api_.close();
}

void SpaceMouse::Poll(Time now) {
  pollfd line{api_.descriptor(), POLLIN, 0};
  if (line.fd < 0 || (poll(&line, 1, 0) > 0 && (line.revents & ~POLLIN) != 0)) closed_ = true;
  SpnavEvent event{};
  for (int i = 0; !closed_ && i < kMaxEvents && api_.poll_event(&event) != 0; ++i)
    TakeEvent(event, now);
  if (SecondsBetween(moved_at_, now) > kMotionLasts) counts_.setZero();
  Input input;
  for (int i = 0; i < 3; ++i) input.share[i] = WithoutDeadZone(counts_[i] / full_scale_);
  input.buttons = buttons_;
  if (unplugged_) input.lost = "spacenavd reports its removal";
  if (closed_) input.lost = "spacenavd has closed the connection";
  input.received_at = now;
  inputs_.Put(input);
}

// The library's z points away from the operator.
void SpaceMouse::TakeEvent(const SpnavEvent& event, Time now) {
  if (event.type == SpnavEvent::kMotion) {
    counts_ = Eigen::Vector3d(event.motion.x, event.motion.y, -event.motion.z);
    moved_at_ = now;
    full_scale_ = std::max(full_scale_, counts_.cwiseAbs().maxCoeff());
  } else if (event.type == SpnavEvent::kDevice) {
    unplugged_ = event.device.change == SpnavEvent::kRemoved;
    counts_.setZero();
    buttons_ = 0;
  } else if (event.type == SpnavEvent::kButton) {
    auto known = std::ranges::find(known_buttons_, event.button.number);
    if (known == known_buttons_.end()) {
      if (known_buttons_.size() >= kMaxButtons) return;
      known_buttons_.push_back(event.button.number);
      known = known_buttons_.end() - 1;
    }
    const auto bit = std::uint32_t{1} << static_cast<unsigned>(known - known_buttons_.begin());
    buttons_ = event.button.press != 0 ? buttons_ | bit : buttons_ & ~bit;
  }
}

DeviceReading SpaceMouse::DoRead(Time now) noexcept {
  const double dt = last_ ? std::clamp(SecondsBetween(*last_, now), 0.0, kMaxStep) : 0;
  last_ = now;
  if (const Input* newest = inputs_.Take()) input_ = *newest;
  const double age = SecondsBetween(input_.received_at, now);
  const bool good = input_.lost == nullptr && age < kSilentAfter;
  const bool engaged = good && (input_.buttons & 1U) != 0;
  const bool moves = engaged && age < kStopAfter;
  intent_.v_M = moves ? Eigen::Vector3d(speed_ * input_.share) : Eigen::Vector3d(0, 0, 0);
  if (!engaged) intent_.p_M = hand_.p_M();  // a released device stays
  intent_.p_M += dt * intent_.v_M;
  hand_.Step(dt, intent_);
  DeviceReading reading{hand_.p_M(), hand_.v_M(), engaged};
  reading.at = input_.received_at;
  reading.status.buttons = input_.buttons;
  if (input_.lost != nullptr) {
    reading.status.fault = DeviceFault::kUnplugged;
    reading.status.cause = input_.lost;
  } else if (!good) {
    reading.status.fault = DeviceFault::kSilent;
  }
  return reading;
}

DeviceOutput SpaceMouse::DoWrite(const Wrench& wrench) noexcept {
  hand_.ApplyForce(wrench.force);
  return DeviceOutput::kOk;
}

Driver SpaceMouseDriver() {
  return {"spacemouse", "3Dconnexion SpaceMouse (libspnav, spacenavd), without force",
          "speed in mm/s, 20 by default",
          [] {
            DriverReport report;
            const LibrarySearch search = SpnavSearch();
            AddLibrary(search, SharedLibrary(search), &report);
            report.next =
                "sudo apt-get install libspnav0 spacenavd; sudo systemctl start spacenavd";
            if (report.missing.empty()) AddOpened(SpaceMouseDriver(), &report);
            if (report.usable) report.next.clear();
            return report;
          },
          [](const std::string& option) -> std::unique_ptr<HapticDevice> {
            return std::make_unique<SpaceMouse>(SpeedOf(option));
          }};
}

}  // namespace palpate
