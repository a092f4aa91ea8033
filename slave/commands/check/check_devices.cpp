// Reports the devices of a laboratory for `check`: cameras, how two of them are paired, and the
// arm.
#include <filesystem>
#include <system_error>

#include <spdlog/fmt/fmt.h>

#include "slave/commands/check/check.h"

namespace palpate {
namespace {

constexpr const char* kPushed = "from a driver (FeedImages)";

std::string InWords(const Eye& eye) {
  switch (eye.kind) {
    case Eye::Kind::kDevice:
      return fmt::format("camera {0} (/dev/video{0})", eye.device);
    case Eye::Kind::kVideo:
      return "video " + eye.address;
    case Eye::Kind::kUrl:
      return (eye.address.find('!') == std::string::npos ? "stream " : "GStreamer pipeline ") +
             eye.address;
  }
  return {};
}

std::string InWords(const StereoCameras& pair) {
  switch (pair.source) {
    case StereoCameras::Source::kSimulated:
      return "simulated";
    case StereoCameras::Source::kFiles:
      return fmt::format("image files {}, right {}", pair.left, pair.right);
    case StereoCameras::Source::kStream:
      return std::string("image pairs ") + kPushed;
    case StereoCameras::Source::kCameras:
      break;
  }
  if (pair.cameras.size() == 1) return InWords(pair.cameras[0]) + ", left and right side by side";
  return fmt::format("left {}, right {}", InWords(pair.cameras[0]), InWords(pair.cameras[1]));
}

std::string InWords(const DepthImages& depth) {
  switch (depth.source) {
    case DepthImages::Source::kFiles:
      return "depth image files " + depth.pattern;
    case DepthImages::Source::kStream:
      return std::string("depth images ") + kPushed;
    case DepthImages::Source::kEye:
      break;
  }
  return InWords(depth.eye);
}

// Returns whether pairs are formed by timestamps.
bool IsPairedByStamps(const StereoCameras& pair) {
  const bool has_two = pair.source == StereoCameras::Source::kCameras && pair.cameras.size() == 2;
  return pair.source == StereoCameras::Source::kStream ||
         (has_two && pair.cameras[0].kind != Eye::Kind::kVideo);
}

void PrintArm(const Scene& scene) {
  using Source = ManipulatorOptions::Source;
  const ManipulatorOptions& arm = scene.manipulator;
  if (arm.source == Source::kSimulated) return PrintLine("manipulator", "simulated");
  if (arm.source == Source::kNone) {
    return PrintLine("manipulator", "none: nobody can engage, no encoders are compared");
  }
  PrintLine(
      "manipulator",
      fmt::format("driven by a client (DriveTool); a fault is raised after {:.3g} ms of silence",
                  1e3 * arm.silence));
}

bool IsLive(const Eye& eye) {
  return eye.kind != Eye::Kind::kVideo;
}

bool IsLive(const SenseOptions& sense) {
  if (TakesImages(sense)) return true;
  if (const auto* depth = sense.Find<DepthImages>()) {
    return depth->source == DepthImages::Source::kEye && IsLive(depth->eye);
  }
  if (const auto* pair = sense.Find<StereoCameras>()) {
    return pair->source == StereoCameras::Source::kCameras && IsLive(pair->cameras[0]);
  }
  const auto* camera = sense.Find<Camera>();
  return camera != nullptr &&
         (camera->source == Camera::Source::kDevice || camera->source == Camera::Source::kUrl);
}

}  // namespace

bool ShowsArm(const Scene& scene) {
  return scene.manipulator.source == ManipulatorOptions::Source::kStream && IsLive(scene.sense);
}

std::string InWords(const Camera& camera) {
  switch (camera.source) {
    case Camera::Source::kSimulated:
      return fmt::format("simulated, {}x{} px", camera.size[0], camera.size[1]);
    case Camera::Source::kFiles:
      return "image files " + camera.pattern;
    case Camera::Source::kVideo:
      return InWords(Eye{.kind = Eye::Kind::kVideo, .address = camera.pattern});
    case Camera::Source::kUrl:
      return InWords(Eye{.kind = Eye::Kind::kUrl, .address = camera.pattern});
    case Camera::Source::kStream:
      return std::string("images ") + kPushed;
    case Camera::Source::kDevice:
      break;
  }
  return InWords(Eye{.kind = Eye::Kind::kDevice, .device = camera.device});
}

void PrintCameras(const Scene& scene) {
  if (const auto* depth = scene.sense.Find<DepthImages>()) {
    return PrintLine("cameras", fmt::format("{}, {:g} Hz", InWords(*depth), depth->rate));
  }
  const auto* pair = scene.sense.Find<StereoCameras>();
  if (pair == nullptr) return;
  PrintLine("cameras", fmt::format("{}, {:g} Hz", InWords(*pair), pair->rate));
  if (!IsPairedByStamps(*pair)) return;
  const bool is_pushed = pair->source == StereoCameras::Source::kStream;
  PrintLine(
      "sync",
      fmt::format("images {} more than {:.3g} ms apart are not paired: they are dropped and "
                  "counted; GetStatus reports the interval",
                  is_pushed ? "whose driver timestamps are" : "that arrive", 1e3 * pair->sync));
}

void PrintManipulator(const Scene& scene) {
  PrintArm(scene);
  if (!ShowsArm(scene)) return;
  PrintLine("checked",
            "the tip in the images against the manipulator's encoders: what they differ by, with "
            "the images' latency, is part of the force's sigma or flagged");
}

}  // namespace palpate
