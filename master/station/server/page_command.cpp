#include "master/station/server/page_command.h"

#include <algorithm>
#include <cmath>
#include <stdexcept>

#include <nlohmann/json.hpp>

namespace palpate {
namespace {

using CommandJson = nlohmann::json;

constexpr double kMaxAim = 10;  // [m]
constexpr std::size_t kMaxKindLength = 40;

[[noreturn]] void RefuseCommand(const std::string& what) {
  throw std::invalid_argument("not understood: " + what);
}

double Number(const CommandJson& command, const char* key) {
  const auto found = command.find(key);
  if (found != command.end() && found->is_number()) {
    const double value = found->get<double>();
    if (std::isfinite(value)) return value;
  }
  RefuseCommand(std::string(key) + ": expected a finite number");
}

std::optional<double> Positive(const CommandJson& command, const char* key) {
  if (!command.contains(key)) return std::nullopt;
  const double value = Number(command, key);
  if (!(value > 0)) RefuseCommand(std::string(key) + ": expected a number above 0");
  return value;
}

PointerCommand ReadPointer(const CommandJson& command) {
  PointerCommand pointer{Number(command, "at"), {0, 0, 0}, command.value("engaged", false)};
  if (command.contains("gap")) pointer.gap = Number(command, "gap");
  if (pointer.gap < 0) RefuseCommand("gap: expected a number of at least 0");
  const auto place = command.find("p_M");
  if (place == command.end() || !place->is_array() || place->size() != 3) {
    RefuseCommand("p_M: expected three numbers");
  }
  for (int i = 0; i < 3; ++i) {
    const CommandJson& number = (*place)[static_cast<std::size_t>(i)];
    const double value = number.is_number() ? number.get<double>() : NAN;
    if (!(std::abs(value) <= kMaxAim)) RefuseCommand("p_M: expected numbers within 10 m");
    pointer.p_M[i] = value;
  }
  return pointer;
}

bool Flag(const CommandJson& command, const char* key) {
  const auto found = command.find(key);
  if (found != command.end() && found->is_boolean()) return found->get<bool>();
  RefuseCommand(std::string(key) + ": expected true or false");
}

RenderCommand ReadRender(const CommandJson& command) {
  if (const auto mode = ParseRenderMode(command.value("mode", ""))) return {*mode};
  RefuseCommand("mode: expected local, interpolate, hold");
}

ReplayCommand ReadReplay(const CommandJson& command) {
  ReplayCommand replay;
  if (command.contains("playing")) replay.playing = Flag(command, "playing");
  replay.speed = Positive(command, "speed");
  if (command.contains("to")) replay.to = Number(command, "to");
  return replay;
}

ModelCommand ReadModel(const CommandJson& command) {
  ModelCommand model{command.value("kind", "")};
  const bool is_name = std::all_of(model.kind.begin(), model.kind.end(), [](char c) {
    return (c >= 'a' && c <= 'z') || (c >= '0' && c <= '9') || c == '-';
  });
  if (model.kind.empty() || model.kind.size() > kMaxKindLength || !is_name) {
    RefuseCommand("kind: expected a model's name");
  }
  return model;
}

PageCommand ReadObject(const CommandJson& command) {
  const std::string what = command.value("do", "");
  if (what == "stop") return StopCommand{};
  if (what == "reset") return ResetCommand{};
  if (what == "ping") return PingCommand{Number(command, "at")};
  if (what == "past") return PastCommand{};
  if (what == "pointer") return ReadPointer(command);
  if (what == "model") return ReadModel(command);
  if (what == "set") {
    return MappingCommand{Positive(command, "position_scale"), Positive(command, "force_scale"),
                          Positive(command, "force_limit")};
  }
  if (what == "mark") return MarkCommand{};
  if (what == "tare") return TareCommand{};
  if (what == "find") return ReinitializeTrackingCommand{};
  if (what == "clutch") return ClutchCommand{Flag(command, "on")};
  if (what == "record") return RecordCommand{Flag(command, "on")};
  if (what == "field") return FieldCommand{Flag(command, "on")};
  if (what == "render") return ReadRender(command);
  if (what == "replay") return ReadReplay(command);
  RefuseCommand(
      "do: expected stop, reset, ping, past, pointer, set, model, mark, tare, find, "
      "clutch, record, render, replay, field");
}

}  // namespace

PageCommand ReadPageCommand(std::string_view message) {
  if (message.size() > kMaxCommandBytes) RefuseCommand("expected at most 1024 bytes");
  const CommandJson command = CommandJson::parse(message, nullptr, false);
  if (!command.is_object()) RefuseCommand("expected a JSON object");
  try {
    return ReadObject(command);
  } catch (const CommandJson::exception&) {  // a value of another type
    RefuseCommand("a value is of another type than accepted");
  }
}

}  // namespace palpate
