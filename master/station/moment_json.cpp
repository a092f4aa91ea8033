#include "master/station/moment_json.h"

#include <cmath>
#include <cstring>

#include <nlohmann/json.hpp>

#include "master/station/alarms.h"
#include "shared/wire/state_message.h"

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

Json Parsed(const std::string& text) {
  Json json = Json::parse(text, nullptr, false);
  return json.is_discarded() ? Json() : json;
}

Json ReasonsOf(const Reasons& reasons) {
  Json names = Json::array();
  for (std::size_t i = 0; i < kReasonCount; ++i) {
    const auto reason = static_cast<Reason>(i);
    if (reasons.Has(reason)) names.push_back(ToString(reason));
  }
  return names;
}

Json ChainOf(const ForceChain& chain) {
  return {{"estimated", chain.force_known ? Triple(chain.estimated) : Json()},
          {"local", Triple(chain.local)},
          {"scaled", Triple(chain.scaled)},
          {"passive", Triple(chain.passive)},
          {"limited", Triple(chain.limited)},
          {"sent", Triple(chain.sent)},
          {"reasons", ReasonsOf(chain.reasons)}};
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

// The newest state with the field names and values of state.proto, and its age [s].
Json SlaveStateOf(const StationMoment& moment) {
  if (moment.observed.state.sequence == 0) return nullptr;
  v1::SlaveState message;
  ToProto(moment.observed.state, &message);
  Json json = Parsed(JsonOf(message));
  json["age"] = Number(moment.observed_age);
  json["details"] = Parsed(moment.observed.details);
  return json;
}

Json FingersOf(const std::vector<NamedFinger>& named) {
  Json fingers = Json::array();
  for (const NamedFinger& finger : named) {
    fingers.push_back({{"name", finger.name},
                       {"place", Triple(finger.contact.p_S_contact)},
                       {"force", finger.contact.force ? Triple(*finger.contact.force) : Json()},
                       {"in_contact", finger.contact.in_contact},
                       {"validity", ToString(finger.contact.validity)}});
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
               {"libraries", hello.libraries},
               {"version", hello.version}});
}

void LeaveOutOld(StationMoment* moment) {
  constexpr double kOld = 0.250;  // [s]
  SlaveState& state = moment->observed.state;
  if (moment->observed_age > kOld) {
    state.validity = Validity::kStale;
    state.check = FailedCheck::kNone;
    state.sigma = std::nan("");
    state.local_model = {};
    moment->observed.details.clear();
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
  return Text({{"kind", "status"},
               {"t", moment.ticks.t},
               {"state", ToString(tick.state)},
               {"epoch", tick.epoch},
               {"p_M", Triple(tick.p_M)},
               {"p_S", Triple(tick.p_S)},
               {"chain", ChainOf(tick.chain)},
               {"force_limit", moment.status.force_limit},
               {"position_scale", tick.position_scale},
               {"force_scale", tick.force_scale},
               {"waiting", WaitingOf(moment.waiting)},
               {"rate", moment.ticks.rate > 0 ? Json(moment.ticks.rate) : Json()},
               {"missed", moment.ticks.missed},
               {"link", LinkOf(moment)},
               {"device", moment.replay ? Json() : DeviceOf(tick.device)},
               {"fingers", FingersOf(moment.status.fingers)},
               {"slave_state", SlaveStateOf(moment)},
               {"pointer_holds", moment.pointer_holds},
               {"pointer_used", moment.pointer_used},
               {"video_trouble", moment.video_trouble},
               {"mesh_trouble", moment.mesh_trouble},
               {"marks", tick.marks},
               {"render", ToString(tick.render)},
               {"clutched", tick.clutched},
               {"tare", Triple(tick.tare)},
               {"recording", RecordingOf(moment)},
               {"replay", ReplayOf(moment)},
               {"trace", TraceOf(moment)},
               {"alarms", AlarmJson(AlarmsOf(moment))},
               {"samples", SamplesOf(moment.ticks.samples)}});
}

std::string HealthJson(const SlaveTexts& texts) {
  return Text({{"kind", "health"},
               {"scene", Parsed(texts.scene)},
               {"status", Parsed(texts.status)},
               {"trouble", texts.trouble}});
}

std::vector<std::string> AlarmsIn(const SlaveTexts& texts) {
  constexpr std::size_t kMaxAlarms = 8;
  std::vector<std::string> alarms;
  const Json status = Parsed(texts.status);
  if (!status.is_object()) return alarms;
  for (const Json& alarm : status.value("alarms", Json::array())) {
    if (alarm.is_string() && alarms.size() < kMaxAlarms) alarms.push_back(alarm.get<std::string>());
  }
  return alarms;
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

}  // namespace palpate
