#include "slave/commands/scene_remarks.h"

#include <cmath>
#include <stdexcept>
#include <utility>

#include <spdlog/spdlog.h>

#include "slave/mechanics/factory/choose_model.h"
#include "slave/scene/scene_text.h"
#include "slave/solve/object_remarks.h"
#include "slave/vision/stereo/rig.h"

namespace palpate {
namespace {

using Remarks = std::vector<std::string>;

constexpr double kMaxPixel = 5e-3;  // [m]

void AddBaseline(const StereoCameras& cameras, const Object& object, Remarks* remarks) {
  if (cameras.rig.empty()) return;
  const double baseline = ReadRig(cameras.rig).baseline();
  const double distance = (cameras.X_SL.inverse() * object.X_SO.translation()).norm();
  if (baseline <= distance) return;
  remarks->push_back(fmt::format(
      "{}: the baseline of {} is larger than the distance of {} to the object: probably "
      "millimetres; T of a rig is in metres",
      cameras.rig.string(), LengthInWords(baseline), LengthInWords(distance)));
}

}  // namespace

std::vector<std::string> RemarksOn(const Scene& scene) {
  Remarks remarks;
  try {
    remarks = RemarksOnObject(scene);
    if (const auto* camera = scene.sense.Find<Camera>(); camera && camera->pixel > kMaxPixel) {
      remarks.push_back(fmt::format("sense.camera.pixel of {} is larger than 5 mm",
                                    LengthInWords(camera->pixel)));
    }
    if (const auto* cameras = scene.sense.Find<StereoCameras>()) {
      AddBaseline(*cameras, scene.object, &remarks);
    }
  } catch (const std::invalid_argument&) {
  } catch (const std::runtime_error&) {
  }
  return remarks;
}

void LogRemarks(const Scene& scene) {
  for (const std::string& remark : RemarksOn(scene)) spdlog::warn("{}", remark);
}

Scene LoadRunningScene(const std::filesystem::path& file, const std::vector<std::string>& overrides,
                       SceneUse use) {
  Scene scene = LoadScene(file, overrides, use);
  LogRemarks(scene);
  if (scene.model.kind != "auto") return scene;
  scene = WithChosenModel(std::move(scene));
  spdlog::info("{}: {}", scene.model.kind, scene.model.reason);
  return scene;
}

std::string MissingGuards(const ManipulatorOptions& arm) {
  if (arm.source == ManipulatorOptions::Source::kNone) return {};
  const bool presses = std::isinf(arm.force_guard), sinks = std::isinf(arm.depth_guard);
  if (!presses && !sinks) return {};
  const char* keys = !sinks     ? "manipulator.force_guard is"
                     : !presses ? "manipulator.depth_guard is"
                                : "manipulator.force_guard and manipulator.depth_guard are";
  return fmt::format("{} not set: nothing limits the {} of an operator who engages again and again",
                     keys,
                     !sinks     ? "force"
                     : !presses ? "depth"
                                : "force and depth");
}

}  // namespace palpate
