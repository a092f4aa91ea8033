#include "master/station/wish.h"

#include <algorithm>
#include <cmath>
#include <stdexcept>

#include <nlohmann/json.hpp>

namespace palpate {
namespace {

using Json = nlohmann::json;

constexpr double kFarthestAim = 10;  // [m]
constexpr std::size_t kLongestKind = 40;

[[noreturn]] void RefuseWish(const std::string& what) {
  throw std::invalid_argument("not understood: " + what);
}

double Number(const Json& wish, const char* key) {
  const auto found = wish.find(key);
  if (found != wish.end() && found->is_number()) {
    const double value = found->get<double>();
    if (std::isfinite(value)) return value;
  }
  RefuseWish(std::string(key) + ": accepted is a finite number");
}

std::optional<double> Positive(const Json& wish, const char* key) {
  if (!wish.contains(key)) return std::nullopt;
  const double value = Number(wish, key);
  if (!(value > 0)) RefuseWish(std::string(key) + ": accepted is a number above 0");
  return value;
}

PointerWish ReadPointer(const Json& wish) {
  PointerWish pointer{Number(wish, "at"), {0, 0, 0}, wish.value("engaged", false)};
  const auto place = wish.find("p_M");
  if (place == wish.end() || !place->is_array() || place->size() != 3) {
    RefuseWish("p_M: accepted are three numbers");
  }
  for (int i = 0; i < 3; ++i) {
    const Json& number = (*place)[static_cast<std::size_t>(i)];
    const double value = number.is_number() ? number.get<double>() : NAN;
    if (!(std::abs(value) <= kFarthestAim)) RefuseWish("p_M: accepted are numbers within 10 m");
    pointer.p_M[i] = value;
  }
  return pointer;
}

bool Flag(const Json& wish, const char* key) {
  const auto found = wish.find(key);
  if (found != wish.end() && found->is_boolean()) return found->get<bool>();
  RefuseWish(std::string(key) + ": accepted is true or false");
}

RenderWish ReadRender(const Json& wish) {
  if (const auto mode = ParseRenderMode(wish.value("mode", ""))) return {*mode};
  RefuseWish("mode: accepted are local, interpolate, hold");
}

ReplayWish ReadReplay(const Json& wish) {
  ReplayWish replay;
  if (wish.contains("playing")) replay.playing = Flag(wish, "playing");
  replay.speed = Positive(wish, "speed");
  if (wish.contains("to")) replay.to = Number(wish, "to");
  return replay;
}

ModelWish ReadModel(const Json& wish) {
  ModelWish model{wish.value("kind", "")};
  const bool is_name = std::all_of(model.kind.begin(), model.kind.end(), [](char c) {
    return (c >= 'a' && c <= 'z') || (c >= '0' && c <= '9') || c == '-';
  });
  if (model.kind.empty() || model.kind.size() > kLongestKind || !is_name) {
    RefuseWish("kind: accepted is a model's name");
  }
  return model;
}

Wish ReadObject(const Json& wish) {
  const std::string what = wish.value("do", "");
  if (what == "stop") return StopWish{};
  if (what == "reset") return ResetWish{};
  if (what == "ping") return PingWish{Number(wish, "at")};
  if (what == "past") return PastWish{};
  if (what == "pointer") return ReadPointer(wish);
  if (what == "model") return ReadModel(wish);
  if (what == "set") {
    return MappingWish{Positive(wish, "position_scale"), Positive(wish, "force_scale"),
                       Positive(wish, "force_limit")};
  }
  if (what == "mark") return MarkWish{};
  if (what == "tare") return TareWish{};
  if (what == "find") return FindWish{};
  if (what == "examine") return ExamineWish{};
  if (what == "clutch") return ClutchWish{Flag(wish, "on")};
  if (what == "record") return RecordWish{Flag(wish, "on")};
  if (what == "render") return ReadRender(wish);
  if (what == "replay") return ReadReplay(wish);
  RefuseWish(
      "do: accepted are stop, reset, ping, past, pointer, set, model, mark, tare, find, "
      "examine, clutch, record, render, replay");
}

}  // namespace

Wish ReadWish(std::string_view message) {
  if (message.size() > kLongestWish) RefuseWish("accepted are at most 1024 bytes");
  const Json wish = Json::parse(message, nullptr, false);
  if (!wish.is_object()) RefuseWish("accepted is a JSON object");
  try {
    return ReadObject(wish);
  } catch (const Json::exception&) {  // a value of another type
    RefuseWish("a value is of another type than accepted");
  }
}

}  // namespace palpate
