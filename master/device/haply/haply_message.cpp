#include "master/device/haply/haply_message.h"

#include <array>
#include <cmath>
#include <cstdlib>

#include <nlohmann/json.hpp>

#include "shared/text/text.h"

namespace palpate {
namespace {

using Json = nlohmann::json;

Json Parsed(const std::string& text) {
  Json json = Json::parse(text, nullptr, false);
  return json.is_discarded() ? Json() : json;
}

// The member `key` of an object; null where there is none.
const Json& At(const Json& json, const char* key) {
  static const Json kNull;
  if (!json.is_object()) return kNull;
  const auto found = json.find(key);
  return found == json.end() ? kNull : *found;
}

const Json& First(const Json& json, const char* key) {
  static const Json kNull;
  const Json& list = At(json, key);
  return list.is_array() && !list.empty() ? list.front() : kNull;
}

std::optional<double> Number(const Json& json, const char* key) {
  const Json& value = At(json, key);
  if (!value.is_number()) return std::nullopt;
  const double number = value.get<double>();
  return std::isfinite(number) ? std::optional(number) : std::nullopt;
}

std::optional<Eigen::Vector3d> Triple(const Json& json) {
  const auto x = Number(json, "x"), y = Number(json, "y"), z = Number(json, "z");
  if (!x || !y || !z) return std::nullopt;
  return Eigen::Vector3d(*x, *y, *z);
}

bool Flag(const Json& json, const char* key, bool fallback) {
  const Json& value = At(json, key);
  return value.is_boolean() ? value.get<bool>() : fallback;
}

void AddGrip(const Json& grip, HaplyState* state) {
  if (!grip.is_object()) return;
  const Json& status = At(grip, "status");
  state->has_grip = Flag(status, "awake", true) && Flag(status, "connected", true);
  const Json& values = At(grip, "state");
  const auto w = Number(At(values, "orientation"), "w");
  const auto axis = Triple(At(values, "orientation"));
  if (w && axis) state->orientation = Eigen::Quaterniond(*w, axis->x(), axis->y(), axis->z());
  // A grip with a cable.
  if (state->has_grip && Flag(values, "button", false)) state->buttons |= 1U;
  constexpr std::array<const char*, 4> kButtons{"a", "b", "c", "home"};
  for (std::size_t i = 0; state->has_grip && i < kButtons.size(); ++i) {
    if (Flag(At(values, "buttons"), kButtons[i], false)) state->buttons |= 1U << i;
  }
}

}  // namespace

std::optional<HaplyState> ParseHaplyState(const std::string& text) {
  const Json json = Parsed(text);
  if (!At(json, "inverse3").is_array()) return std::nullopt;
  HaplyState state;
  const Json& arm = First(json, "inverse3");
  const Json& id = At(arm, "device_id");
  if (!id.is_string()) return state;  // no device
  const auto position = Triple(At(At(arm, "state"), "cursor_position"));
  if (!position) return std::nullopt;
  state.id = id.get<std::string>();
  state.position = *position;
  state.velocity = Triple(At(At(arm, "state"), "cursor_velocity"));
  state.force = Triple(At(At(arm, "state"), "current_cursor_force"));
  state.calibrated = Flag(At(arm, "status"), "calibrated", true);
  state.gate_gain = Number(At(At(At(arm, "config"), "filters"), "force_gate"), "gain");
  const Json& wireless = First(json, "wireless_verse_grip");
  AddGrip(wireless.is_object() ? wireless : First(json, "verse_grip"), &state);
  return state;
}

std::string HaplyForceMessage(const std::string& id, const Eigen::Vector3d& force, HaplyForm form) {
  const Json axes = {{"x", force.x()}, {"y", force.y()}, {"z", force.z()}};
  Json value;
  if (form != HaplyForm::kVector) value["values"] = axes;
  if (form != HaplyForm::kValues) value["vector"] = axes;
  const Json command = {{"set_cursor_force", value}};
  const Json message = {{"inverse3", Json::array({{{"device_id", id}, {"commands", command}}})}};
  return message.dump(-1, ' ', false, Json::error_handler_t::replace);
}

std::string HaplyStateRequest() {
  return R"({"session": {"force_render_full_state": {}}})";
}

std::string HaplyRelease(const std::string& version_text) {
  const Json json = Parsed(version_text);
  for (const char* key : {"git_tag", "project_version", "version"}) {
    const Json& value = At(json, key);
    if (value.is_string()) return Presentable(value.get<std::string>(), 20);
  }
  return {};
}

HaplyForm HaplyFormOf(const std::string& version_text) {
  std::string release = HaplyRelease(version_text);
  if (release.starts_with('v')) release.erase(0, 1);
  const std::size_t dot = release.find('.');
  if (dot == std::string::npos) return HaplyForm::kBoth;
  const auto major = ParseFinite(release.substr(0, dot));
  const auto minor = ParseFinite(release.substr(dot + 1, release.find('.', dot + 1) - dot - 1));
  if (!major || !minor) return HaplyForm::kBoth;
  const double number = *major + *minor / 100;
  constexpr double kLastValues = 3.03, kFirstVector = 3.05;
  if (number > kLastValues && number < kFirstVector) return HaplyForm::kBoth;
  return number <= kLastValues ? HaplyForm::kValues : HaplyForm::kVector;
}

std::optional<HaplySessions> ParseHaplySessions(const std::string& text) {
  const Json json = Parsed(text);
  const Json& list = json.is_array() ? json : At(json, "sessions");
  if (!list.is_array()) return std::nullopt;
  return HaplySessions{list.size(), Number(json, "force_scale").value_or(1)};
}

}  // namespace palpate
