#include "tests/slave/simulator/simulated_devices.h"

#include <cmath>
#include <stdexcept>
#include <string>
#include <utility>

#include <opencv2/core.hpp>
#include <opencv2/imgproc.hpp>

#include "slave/capture/image_inbox.h"
#include "tests/support/eventually.h"

namespace palpate {
namespace {

constexpr std::uint64_t kId = 1;
constexpr double kArmPeriod = 1e-3, kArmLag = 3e-3;  // of the manipulator [s]

cv::Mat Displaced(const cv::Mat& image, int down) {
  if (down == 0) return image;
  const cv::Mat warp = (cv::Mat_<double>(2, 3) << 1, 0, 0, 0, 1, down);
  cv::Mat displaced;
  cv::warpAffine(image, displaced, warp, {}, cv::INTER_NEAREST, cv::BORDER_REPLICATE);
  return displaced;
}

}  // namespace

SimulatedDevices::SimulatedDevices(Scene scene, Slave* slave)
    : scene_(std::move(scene)), slave_(*slave), environment_(MakeSimulatedEnvironment(scene_)) {
  environment_->SolveAhead();
  environment_->MoveTool(scene_.manipulator.home, WhenUnsolved::kUseNearest);
  drive_ = std::jthread([this](const std::stop_token& stop) { Drive(stop); });
  feed_ = std::jthread([this](const std::stop_token& stop) { FeedImages(stop); });
  const bool is_ready = Eventually([&] {
    const SlaveStatus status = slave_.Status();
    return status.cameras->trouble.empty() && status.arm->fault.empty() &&
           slave_.Compose(Clock::now()).force.has_value();
  });
  if (!is_ready) throw std::runtime_error("the slave uses no simulated images");
}

void SimulatedDevices::FeedImages(const std::stop_token& stop) {
  const auto camera = environment_->OpenCamera(scene_, {});
  while (const auto frame = camera->Next(stop)) {
    cv::Mat image = Displaced(frame->image, displacement_);
    if (is_covered_) image = cv::Mat(image.size(), image.type(), cv::Scalar::all(255));
    const std::string data(reinterpret_cast<const char*>(image.data),
                           image.total() * image.elemSize());
    PushedSample sample{.sequence = frame->sequence, .sensed_at = frame->sensed_at};
    sample.image = {
        image.channels() == 3 ? PushedImage::Encoding::kBgr8 : PushedImage::Encoding::kGrey8, &data,
        static_cast<unsigned>(image.cols), static_cast<unsigned>(image.rows)};
    const Time now = Clock::now();
    sample.delay = SecondsBetween(sample.sensed_at, now);
    if (const auto refusal = slave_.image_inbox()->Feed(sample, now, kId)) {
      throw std::runtime_error(refusal->why);
    }
  }
}

void SimulatedDevices::Drive(const std::stop_token& stop) {
  ArmReading reading;
  reading.p_S_tip = scene_.manipulator.home;
  for (auto wake = std::chrono::steady_clock::now(); !stop.stop_requested();) {
    const ArmAim aim = slave_.driven_arm()->Aim(Clock::now());
    if (aim.motion == ArmAim::Motion::kFollow) {
      reading.p_S_tip += (1 - std::exp(-kArmPeriod / kArmLag)) * (aim.p_S_tip - reading.p_S_tip);
    }
    environment_->MoveTool(reading.p_S_tip, WhenUnsolved::kUseNearest);
    const Truth truth = environment_->truth();
    reading.force = truth.solved ? std::optional(truth.force) : std::nullopt;
    ++reading.sequence;
    reading.measured_at = Clock::now();
    slave_.driven_arm()->Take(kId, "simulator", reading, Clock::now());
    std::this_thread::sleep_until(wake += std::chrono::milliseconds(1));
  }
}

}  // namespace palpate
