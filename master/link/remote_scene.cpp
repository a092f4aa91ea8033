#include "master/link/remote_scene.h"

#include <algorithm>
#include <cmath>
#include <stdexcept>

#include <Eigen/Geometry>

#include "palpate/v1/scene.pb.h"

#include "shared/text/text.h"
#include "shared/wire/fields.h"

namespace palpate {
namespace {

constexpr const char* kUnitQuaternion = "four: a unit quaternion w, x, y, z";
constexpr std::size_t kMaxWordsLength = 200;  // [characters]

[[noreturn]] void Refuse(const std::string& field, double value, const std::string& accepted) {
  throw std::runtime_error(
      Formatted("the slave's scene: %s = %g: expected %s", field.c_str(), value, accepted.c_str()));
}

double Positive(const char* field, double value) {
  if (!(value > 0 && std::isfinite(value))) Refuse(field, value, "a finite number above 0");
  return value;
}

double NonNegative(const char* field, double value) {
  if (!(value >= 0 && std::isfinite(value))) Refuse(field, value, "a finite number, 0 or more");
  return value;
}

Eigen::Matrix3d Rotation(const v1::SceneDescription::Operator& mapping) {
  std::string reason;
  const auto R_SM = FieldReader(&reason).Rotation("operator.orientation", mapping.orientation());
  if (!R_SM) Refuse("operator.orientation: numbers", mapping.orientation_size(), kUnitQuaternion);
  return R_SM->toRotationMatrix();
}

// The force continues for this time after a lost link, so the slave's value is bounded.
double DeadAfter(double stated) {
  if (stated == 0) return kUsualDeadAfter;
  if (!(stated >= kMinDeadAfter && stated <= kMaxDeadAfter)) {
    Refuse("operator.dead_after", stated, "0.010 to 0.500 s");
  }
  return stated;
}

RemoteFingertip Fingertip(const v1::SceneDescription::Fingertip& message) {
  RemoteFingertip fingertip{Presentable(message.name(), kMaxWordsLength),
                            Presentable(message.network(), kMaxWordsLength),
                            {}};
  const auto& p = message.p_s_finger();
  fingertip.p_S_home = {p.x(), p.y(), p.z()};
  const double far = fingertip.p_S_home.norm();
  if (!(far <= kMaxLength)) {
    Refuse("fingertips.p_S_finger of " + message.name(), far, "a position at most 1e6 m away");
  }
  return fingertip;
}

}  // namespace

std::string OtherRelease(const std::string& slave, const std::string& master) {
  const std::string theirs = slave.substr(0, slave.find('+')),
                    ours = master.substr(0, master.find('+'));
  if (theirs.empty() || ours.empty() || theirs == ours) return {};
  return "The slave is of release " + theirs + ", this master of " + ours + ".";
}

double MaxAge(double sensor_rate) {
  constexpr double kOnTop = 0.1, kMinAge = 0.06, kMaxAge = 1, kPeriods = 3;  // [s], [s], [s], [-]
  return kOnTop + std::clamp(kPeriods / std::max(sensor_rate, kPeriods), kMinAge, kMaxAge);
}

RemoteScene ToRemoteScene(const v1::SceneDescription& scene) {
  const auto& mapping = scene.operator_();
  const auto& capabilities = scene.capabilities();
  RemoteScene remote;
  remote.name = Presentable(scene.name(), kMaxWordsLength);
  remote.geometry = Presentable(scene.geometry(), kMaxWordsLength);
  remote.model = Presentable(scene.model().kind(), kMaxWordsLength);
  remote.source = Presentable(scene.source(), kMaxWordsLength);
  remote.version = Presentable(capabilities.version(), kMaxWordsLength);
  remote.sensor_rate = NonNegative("sensor_rate", capabilities.sensor_rate());
  remote.accepts_setup = !scene.setup_camera().empty();
  if (remote.accepts_setup && remote.name.empty()) return remote;  // there is no scene yet
  remote.transform.position_scale = Positive("operator.position_scale", mapping.position_scale());
  remote.transform.force_scale = Positive("operator.force_scale", mapping.force_scale());
  remote.transform.R_SM = Rotation(mapping);
  remote.force_limit = Positive("operator.force_limit", mapping.force_limit());
  remote.settings_revision = scene.settings_revision();
  remote.press_depth = NonNegative("operator.press_depth", mapping.press_depth());
  remote.press_speed = NonNegative("operator.press_speed", mapping.press_speed());
  remote.dead_after = DeadAfter(mapping.dead_after());
  remote.simulated = capabilities.simulated();
  for (const auto& message : scene.fingertips()) remote.fingertips.push_back(Fingertip(message));
  return remote;
}

}  // namespace palpate
