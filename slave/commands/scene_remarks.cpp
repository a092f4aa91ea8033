#include "slave/commands/scene_remarks.h"

#include <stdexcept>

#include <spdlog/spdlog.h>

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

}  // namespace palpate
