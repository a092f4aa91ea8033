#include "master/watch/fleet.h"

#include <algorithm>
#include <cmath>
#include <utility>

#include <nlohmann/json.hpp>

#include "palpate/v1/state.pb.h"
#include "palpate/v1/telemetry.pb.h"

#include "shared/nats/nats_connection.h"
#include "shared/text/text.h"
#include "shared/wire/enum_names.h"
#include "shared/wire/fields.h"
#include "shared/wire/state_message.h"

namespace palpate {
namespace {

constexpr std::size_t kMaxNameLength = 40, kMaxAlarmLength = 200;  // characters
constexpr int kMaxAlarms = 20;                                     // alarms per slave
// Time for which an alarm about two slaves with one name remains [s].
constexpr double kDoubledFor = 10;

template <class Message>
bool Parse(std::string_view bytes, Message* message) {
  return message->ParseFromArray(bytes.data(), static_cast<int>(bytes.size()));
}

std::string OrDash(const std::optional<double>& value, const char* format, double scale = 1) {
  return value ? Formatted(format, scale * *value) : "-";
}

}  // namespace

void Fleet::Take(std::string_view subject, std::string_view bytes, Time now) {
  const auto [slave, kind] = PartsOf(subject);
  if (kind != "state" && kind != "status") return;
  const std::scoped_lock lock(mutex_);
  const std::string name = Presentable(slave, kMaxNameLength);
  auto found = entries_.find(name);
  if (found == entries_.end()) {
    if (entries_.size() >= kMaxSlaves) return;
    found = entries_.emplace(name, Entry{.came = now, .counted = now}).first;
  }
  if (kind == "state") {
    TakeState(bytes, now, &found->second);
  } else {
    TakeStatus(bytes, now, &found->second);
  }
}

void Fleet::TakeState(std::string_view bytes, Time now, Entry* entry) {
  v1::SlaveState message;
  std::string why = "no state of palpate.v1";
  auto state = Parse(bytes, &message) ? FromProto(message, &why) : std::nullopt;
  entry->unreadable = state ? "" : Presentable(why, kMaxAlarmLength);
  entry->state = std::move(state);
  entry->came = now;
  ++entry->states;
}

void Fleet::TakeStatus(std::string_view bytes, Time now, Entry* entry) {
  v1::Status message;
  if (!Parse(bytes, &message)) return;
  entry->alarms.clear();
  for (const std::string& alarm : message.alarms()) {
    if (entry->alarms.size() < kMaxAlarms)
      entry->alarms.push_back(Presentable(alarm, kMaxAlarmLength));
  }
  std::string why;
  FieldReader reader(&why);
  const Time started = reader.Stamp("started_at", message.started_at());
  // A restarted slave has a later start time; an earlier one means two slaves with one name.
  if (entry->started && started < *entry->started) entry->doubled = now;
  entry->started = started;
}

SlaveLine Fleet::LineOf(const std::string& name, const Entry& entry, Time now) {
  SlaveLine line{.name = name, .validity = "silent", .alarms = entry.alarms};
  const double quiet = SecondsBetween(entry.came, now);
  const bool is_silent = quiet > kSilentAfter;
  if (!entry.unreadable.empty()) {
    if (!is_silent) line.validity = "unreadable";
    line.alarms.push_back("its states are unreadable: " + entry.unreadable);
  } else if (entry.state) {
    const SlaveState& state = *entry.state;
    line.phase = ProtoNameOf(*v1::Phase_descriptor()->FindValueByNumber(ToProto(state.phase)));
    line.age = std::max(0.0, SecondsBetween(state.sensed_at, state.sent_at)) + quiet;
    if (!is_silent) {
      line.validity = ToString(state.validity);
      line.check = ToString(state.check);
      if (IsForceKnown(state)) line.force = state.force->norm(), line.sigma = state.sigma;
    }
  }
  if (is_silent) line.alarms.push_back(Formatted("no state for %.0f s", quiet));
  if (entry.doubled && SecondsBetween(*entry.doubled, now) < kDoubledFor)
    line.alarms.emplace_back("two slaves publish with this name");
  return line;
}

std::vector<SlaveLine> Fleet::Lines(Time now) {
  const std::scoped_lock lock(mutex_);
  std::vector<SlaveLine> lines;
  for (auto& [name, entry] : entries_) {
    SlaveLine& line = lines.emplace_back(LineOf(name, entry, now));
    const double seconds = SecondsBetween(entry.counted, now);
    if (seconds > 0) line.rate = std::exchange(entry.states, 0) / seconds;
    entry.counted = now;
  }
  return lines;
}

std::vector<std::string> FleetTable(const std::vector<SlaveLine>& lines) {
  std::size_t width = 5;
  for (const SlaveLine& line : lines) width = std::max(width, line.name.size());
  const int columns = static_cast<int>(width);
  std::vector<std::string> table{Formatted("%-*s  %9s  %9s  %-13s  %-9s  %8s  %5s  %s", columns,
                                           "slave", "force N", "sigma N", "validity", "phase",
                                           "age ms", "Hz", "alarms")};
  for (const SlaveLine& line : lines) {
    std::string alarms = line.check.empty() ? "" : "check " + line.check;
    for (const std::string& alarm : line.alarms) alarms += (alarms.empty() ? "" : "; ") + alarm;
    table.push_back(Formatted("%-*s  %9s  %9s  %-13s  %-9s  %8s  %5.1f  %s", columns,
                              line.name.c_str(), OrDash(line.force, "%.4g").c_str(),
                              OrDash(line.sigma, "%.2g").c_str(), line.validity.c_str(),
                              line.phase.c_str(), OrDash(line.age, "%.0f", 1e3).c_str(), line.rate,
                              alarms.c_str()));
  }
  return table;
}

std::string FleetJson(const SlaveLine& line) {
  const auto number = [](const std::optional<double>& value) {
    return value && std::isfinite(*value) ? nlohmann::ordered_json(*value) : nullptr;
  };
  const nlohmann::ordered_json json{
      {"slave", line.name},        {"force_N", number(line.force)}, {"sigma_N", number(line.sigma)},
      {"validity", line.validity}, {"check", line.check},           {"phase", line.phase},
      {"age_s", number(line.age)}, {"rate_hz", line.rate},          {"alarms", line.alarms}};
  return json.dump();
}

}  // namespace palpate
