#include "master/station/moment_json.h"

#include <algorithm>
#include <cmath>
#include <cstring>
#include <string_view>
#include <utility>

#include <nlohmann/json.hpp>

#include "master/haptics/tick_message.h"
#include "master/station/alarms.h"
#include "shared/wire/fields.h"
#include "shared/wire/message_json.h"

namespace palpate {
namespace {

using Json = nlohmann::ordered_json;

constexpr double kMicro = 1e-6;

std::string Text(const Json& json) {
  return json.dump(-1, ' ', false, Json::error_handler_t::replace);
}

Json Number(double value) {
  return std::isfinite(value) ? Json(value) : Json();
}

template <class Vector>
Json Triple(const Vector& v) {
  return Json::array({Number(v.x()), Number(v.y()), Number(v.z())});
}

// Returns `json` with more members, each a key with its value as JSON text; an empty text is null.
std::string With(const Json& json,
                 const std::vector<std::pair<std::string_view, std::string>>& more) {
  std::string text = Text(json);
  text.pop_back();
  for (const auto& [key, value] : more) {
    text.append(",\"").append(key).append("\":").append(value.empty() ? "null" : value);
  }
  return text + "}";
}

std::string TickJson(const TickRecord& record) {
  v1::ForceTick tick;
  ToProto(record, &tick);
  return JsonOf(tick);
}

template <class Message>
std::string JsonIfAny(const std::optional<Message>& message) {
  return message ? JsonOf(*message) : std::string();
}

Json LinkOf(const StationMoment& moment) {
  const LinkStats& link = moment.status.link;
  const LineState line = LineOf(moment);
  return {
      {"connected", link.connected},
      {"observes", link.observes},
      {"word", line.word},
      {"why", line.why},
      {"role", line.role},
      {"round_trip", moment.ticks.round_trip > 0 ? Json(moment.ticks.round_trip) : Json()},
      {"rtt_p50", link.rtt_p50_us > 0 ? Json(link.rtt_p50_us * kMicro) : Json()},
      {"rtt_p99", link.rtt_p99_us > 0 ? Json(link.rtt_p99_us * kMicro) : Json()},
      {"age", moment.ticks.newest.state_age >= 0 ? Number(moment.ticks.newest.state_age) : Json()},
      {"sensed_age",
       moment.ticks.newest.sensed_age >= 0 ? Number(moment.ticks.newest.sensed_age) : Json()},
      {"late_share", moment.ticks.late_share},
      {"states", link.states},
      {"refused", link.refused},
      {"reconnects", link.reconnects},
      {"clock_offset", Number(link.clock_offset)},
      {"trouble", link.trouble}};
}

Json DeviceOf(const DeviceStatus& device) {
  Json buttons = Json::array();
  for (unsigned i = 0; i < 32; ++i) {
    if ((device.buttons >> i & 1U) != 0) buttons.push_back(i + 1);
  }
  return {{"words", InWords(device)},
          {"fault", FaultInWords(device)},
          {"calibration", InWords(device.calibration)},
          {"output", InWords(device.output)},
          {"temperature", Number(static_cast<double>(device.temperature))},
          {"force_share", Number(static_cast<double>(device.force_share))},
          {"buttons", buttons}};
}

Json FingersOf(const std::vector<NamedFinger>& named) {
  Json fingers = Json::array();
  for (const NamedFinger& finger : named) {
    fingers.push_back({{"name", finger.name},
                       {"place", Triple(finger.contact.p_S_contact)},
                       {"force", finger.contact.force ? Triple(*finger.contact.force) : Json()},
                       {"in_contact", finger.contact.in_contact},
                       {"validity", v1::Validity_Name(ToProto(finger.contact.validity))}});
  }
  return fingers;
}

Json AlarmJson(const std::vector<Alarm>& alarms) {
  Json list = Json::array();
  for (const Alarm& alarm : alarms) {
    list.push_back({{"level", ToString(alarm.level)}, {"text", alarm.text}, {"next", alarm.next}});
  }
  return list;
}

Json RecordingOf(const StationMoment& moment) {
  if (!moment.recording) return nullptr;
  return {{"on", moment.recording->on},
          {"megabytes", moment.recording->megabytes},
          {"trouble", moment.recording->trouble}};
}

Json ReplayOf(const StationMoment& moment) {
  if (!moment.replay) return nullptr;
  return {{"playing", moment.replay->playing},
          {"speed", moment.replay->speed},
          {"seconds", moment.replay->seconds},
          {"run", moment.replay->run}};
}

Json TraceOf(const StationMoment& moment) {
  if (!moment.trace) return nullptr;
  const HandTrace& trace = *moment.trace;
  return {{"sample", trace.sample},   {"state", trace.state},     {"t", trace.t},
          {"capture", trace.capture}, {"sensing", trace.sensing}, {"model", trace.model},
          {"wait", trace.wait},       {"wire", trace.wire},       {"tick", trace.tick},
          {"total", trace.total}};
}

template <class T>
Json OrNull(const std::optional<T>& value) {
  return value ? Json(*value) : Json();
}

Json WaitingOf(const SlaveLink::Mapping& waiting) {
  return {{"position_scale", OrNull(waiting.position_scale)},
          {"force_scale", OrNull(waiting.force_scale)},
          {"force_limit", OrNull(waiting.force_limit)}};
}

// Rounded to ten nanometres, which halves the text and suffices for charts.
Json Place(double metres) {
  return Number(std::round(1e8 * metres) / 1e8);
}

// [number, t, scaled, sent, x, y, z, age, round trip, longest tick, energy, tip's x, y, z as
// commanded, and as measured]
Json SamplesOf(const std::vector<TickSample>& taken) {
  Json samples = Json::array();
  for (const TickSample& s : taken) {
    samples.push_back({s.number, s.t, Number(s.scaled), Number(s.sent), Number(s.p_M.x()),
                       Number(s.p_M.y()), Number(s.p_M.z()), s.age >= 0 ? Number(s.age) : Json(),
                       s.round_trip > 0 ? Json(s.round_trip) : Json(), s.longest_tick,
                       Number(s.energy), Place(s.p_S.x()), Place(s.p_S.y()), Place(s.p_S.z()),
                       Place(s.p_S_tip.x()), Place(s.p_S_tip.y()), Place(s.p_S_tip.z())});
  }
  return samples;
}

template <class T>
void Append(const T& value, std::string* bytes) {
  bytes->append(reinterpret_cast<const char*>(&value), sizeof(value));
}

void AppendPlaces(const std::vector<Eigen::Vector3d>& places, std::string* bytes) {
  for (const Eigen::Vector3d& place : places) {
    for (int i = 0; i < 3; ++i) Append(static_cast<float>(place[i]), bytes);
  }
}

template <class Elements>
void AppendElements(const Elements& elements, std::string* bytes) {
  for (const auto& element : elements) {
    for (const int node : element) Append(static_cast<std::uint32_t>(node), bytes);
  }
}

}  // namespace

std::string HelloJson(const StationHello& hello) {
  const RemoteScene& scene = hello.scene;
  Json fingertips = Json::array();
  for (const RemoteFingertip& tip : scene.fingertips) {
    fingertips.push_back({{"name", tip.name}, {"home", Triple(tip.p_S_home)}});
  }
  Json rotation = Json::array();
  for (int i = 0; i < 9; ++i) rotation.push_back(scene.transform.R_SM(i / 3, i % 3));
  return Text({{"kind", "hello"},
               {"badge", hello.badge},
               {"scene", scene.name},
               {"geometry", scene.geometry},
               {"model", scene.model},
               {"source", scene.source},
               {"simulated", scene.simulated},
               {"sensor_rate", scene.sensor_rate},
               {"position_scale", scene.transform.position_scale},
               {"force_scale", scene.transform.force_scale},
               {"rotation", rotation},
               {"force_limit", scene.force_limit},
               {"fingertips", fingertips},
               {"target", hello.target},
               {"encrypted", hello.encrypted},
               {"certificate_until", OrNull(hello.certificate_until)},
               {"device", hello.device},
               {"render", hello.render},
               {"pointer", hello.pointer},
               {"only_observes", hello.only_observes},
               {"libraries", hello.libraries},
               {"version", hello.version}});
}

void LeaveOutOld(StationMoment* moment) {
  constexpr double kOld = 0.250;  // [s]
  if (moment->slave_state_age > kOld) {
    v1::SlaveState& state = moment->slave_state;
    state.set_validity(v1::VALIDITY_STALE);
    state.clear_check();
    state.clear_force();
    state.clear_sigma();
    state.clear_moment();
    state.clear_moment_sigma();
    state.clear_local_model();
    state.clear_details();
  }
  TickRecord& tick = moment->ticks.newest;
  if (tick.state_age <= kOld) return;
  tick.chain.force_known = false;
  for (NamedFinger& finger : moment->status.fingers) {
    finger.contact.validity = Validity::kStale;
    finger.contact.force.reset();
  }
}

std::string StatusJson(const StationMoment& moment) {
  const TickRecord& tick = moment.ticks.newest;
  const bool has_state = moment.slave_state.sequence() > 0;
  const Json json{{"kind", "status"},
                  {"t", moment.ticks.t},
                  {"force_limit", moment.status.force_limit},
                  {"position_scale", tick.position_scale},
                  {"force_scale", tick.force_scale},
                  {"waiting", WaitingOf(moment.waiting)},
                  {"rate", moment.ticks.rate > 0 ? Json(moment.ticks.rate) : Json()},
                  {"missed", moment.ticks.missed},
                  {"link", LinkOf(moment)},
                  {"device", moment.replay ? Json() : DeviceOf(tick.device)},
                  {"fingers", FingersOf(moment.status.fingers)},
                  {"slave_state_age", has_state ? Number(moment.slave_state_age) : Json()},
                  {"pointer_holds", moment.pointer_holds},
                  {"pointer_used", moment.pointer_used},
                  {"pointer_silence", moment.pointer_silence},
                  {"video_trouble", moment.video_trouble},
                  {"mesh_trouble", moment.mesh_trouble},
                  {"render", ToString(tick.render)},
                  {"clutched", tick.clutched},
                  {"recording", RecordingOf(moment)},
                  {"replay", ReplayOf(moment)},
                  {"trace", TraceOf(moment)},
                  {"alarms", AlarmJson(AlarmsOf(moment))},
                  {"samples", SamplesOf(moment.ticks.samples)}};
  return With(json, {{"tick", TickJson(tick)},
                     {"slave_state", has_state ? JsonOf(moment.slave_state) : std::string()}});
}

std::string HealthJson(const SlaveHealth& health) {
  return With({{"kind", "health"}, {"trouble", health.trouble}},
              {{"scene", JsonIfAny(health.scene)}, {"status", JsonIfAny(health.status)}});
}

std::vector<std::string> AlarmsIn(const SlaveHealth& health) {
  constexpr int kMaxAlarms = 8;
  if (!health.status) return {};
  const auto& alarms = health.status->alarms();
  return {alarms.begin(), alarms.begin() + std::min(alarms.size(), kMaxAlarms)};
}

std::string LogJson(const std::vector<LogEntry>& entries) {
  Json list = Json::array();
  for (const LogEntry& entry : entries) {
    list.push_back({{"number", entry.number},
                    {"t", entry.t},
                    {"trouble", entry.is_trouble},
                    {"text", entry.text}});
  }
  return Text({{"kind", "log"}, {"entries", list}});
}

std::string PongJson(double at) {
  return Text({{"kind", "pong"}, {"at", at}});
}

std::string PastJson(const std::vector<TickSample>& samples, std::optional<std::uint64_t> run) {
  return Text(
      {{"kind", "past"}, {"run", run ? Json(*run) : Json()}, {"samples", SamplesOf(samples)}});
}

std::string RefusedJson(const std::string& why) {
  return Text({{"kind", "refused"}, {"text", why}});
}

std::string LedElsewhereJson() {
  return Text({{"kind", "led_elsewhere"}});
}

std::string TopologyBytes(const MeshTopology& topology) {
  const bool is_planar = !topology.lines.empty();
  const std::size_t elements =
      is_planar ? topology.lines.size() : topology.surface.triangles.size();
  std::string bytes;
  Append(static_cast<std::uint32_t>(is_planar ? 2 : 3), &bytes);
  Append(static_cast<std::uint32_t>(topology.surface.nodes.size()), &bytes);
  Append(static_cast<std::uint32_t>(elements), &bytes);
  AppendPlaces(topology.surface.nodes, &bytes);
  if (is_planar) {
    AppendElements(topology.lines, &bytes);
  } else {
    AppendElements(topology.surface.triangles, &bytes);
  }
  for (const std::uint32_t node : topology.fixed_nodes) Append(node, &bytes);
  return bytes;
}

std::string ShapeBytes(const RemoteMesh& mesh) {
  std::string bytes;
  Append(static_cast<std::uint32_t>(mesh.validity), &bytes);
  AppendPlaces(mesh.positions, &bytes);
  for (const float pascals : mesh.traction) Append(pascals, &bytes);
  return bytes;
}

std::string FieldTopologyBytes(const MeshTopology& topology) {
  std::string bytes;
  Append(static_cast<std::uint32_t>(topology.field_rest.size() / 3), &bytes);
  Append(static_cast<std::uint32_t>(topology.field_triangles.size() / 3), &bytes);
  for (const float metres : topology.field_rest) Append(metres, &bytes);
  for (const std::uint32_t node : topology.field_triangles) Append(node, &bytes);
  return bytes;
}

std::string FieldBytes(const RemoteMesh& mesh) {
  std::string bytes;
  Append(static_cast<std::uint32_t>(mesh.validity), &bytes);
  Append(std::uint32_t{mesh.image.empty() ? 0U : 1U}, &bytes);
  for (const float metres : mesh.displacement) Append(metres, &bytes);
  for (const float pixels : mesh.image) Append(pixels, &bytes);
  return bytes;
}

}  // namespace palpate
