#include "slave/scene/decided_model.h"

#include <algorithm>
#include <cmath>
#include <limits>

#include <fmt/format.h>
#include <nlohmann/json.hpp>

#include "slave/scene/model_kinds.h"

namespace palpate {
namespace {

using Json = nlohmann::ordered_json;

// Returns the cells of a box, and null for other geometries.
Json CellsOf(const Geometry& geometry) {
  const auto* box = std::get_if<BoxGeometry>(&geometry);
  return box == nullptr ? Json() : Json(box->cells);
}

// Reads a number; null is an unknown one.
double NumberOf(const Json& json) {
  return json.is_null() ? std::numeric_limits<double>::quiet_NaN() : json.get<double>();
}

template <class Enum>
void Choose(const Json& json, Enum last, Enum* chosen) {
  const int value = json.get<int>();
  if (value < 0 || value > static_cast<int>(last)) throw std::out_of_range("choice");
  *chosen = static_cast<Enum>(value);
}

int Between(const Json& json, int least, int most) {
  const int value = json.get<int>();
  if (value < least || value > most) throw std::out_of_range("number");
  return value;
}

Json ToJson(const ModelDecision& decision) {
  Json json{{"reason", decision.reason}, {"meets", decision.meets},   {"error", decision.error},
            {"bound", decision.bound},   {"update", decision.update}, {"rejected", Json::array()}};
  for (const RejectedModel& r : decision.rejected) {
    json["rejected"].push_back({r.model, r.why, r.error, r.update, r.precompute});
  }
  return json;
}

ModelDecision DecisionOf(const Json& json) {
  ModelDecision decision{json.at("reason"), json.at("meets"), NumberOf(json.at("error")), {}};
  decision.bound = NumberOf(json.at("bound"));
  decision.update = NumberOf(json.at("update"));
  for (const Json& r : json.at("rejected")) {
    decision.rejected.push_back(
        {r.at(0), r.at(1), NumberOf(r.at(2)), NumberOf(r.at(3)), NumberOf(r.at(4))});
  }
  return decision;
}

void Read(const Json& json, ModelOptions* model) {
  model->kind = json.at("kind");
  model->elements = Between(json.at("elements"), 3, 4000);
  model->modes = Between(json.at("modes"), 0, 40);
  model->refinements = Between(json.at("refinements"), 0, 4);
  model->fem.residual = std::clamp(json.at("residual").get<double>(), 1e-14, 0.1);
  Choose(json.at("order"), ElementOrder::kQuadratic, &model->order);
  Choose(json.at("element"), FemOptions::Element::kTet10, &model->fem.element);
  Choose(json.at("law"), FemOptions::Law::kOgden, &model->fem.law);
  model->decision = DecisionOf(json.at("decision"));
}

void ReadCells(const Json& json, Geometry* geometry) {
  auto* box = std::get_if<BoxGeometry>(geometry);
  for (std::size_t i = 0; box != nullptr && i < 3; ++i) {
    box->cells[i] = Between(json.at(i), 1, 1000);
  }
}

std::string Figures(const RejectedModel& r) {
  if (!std::isfinite(r.error)) return {};
  return fmt::format(" ({:.2g} % error, {:.3g} us per update, {:.2g} s of precompute)",
                     100 * r.error, 1e6 * r.update, r.precompute);
}

}  // namespace

Promise OnTolerance(double error, double bound, double tolerance) noexcept {
  if (!(error <= tolerance)) return Promise::kMisses;
  return bound > tolerance ? Promise::kMayMiss : Promise::kMeets;
}

Promise OnRate(double update, double rate) noexcept {
  return update * rate <= 1 ? Promise::kMeets : Promise::kMisses;
}

const char* ToString(Promise promise) {
  switch (promise) {
    case Promise::kMeets:
      return "meets";
    case Promise::kMayMiss:
      return "may miss";
    case Promise::kMisses:
      break;
  }
  return "MISSES";
}

std::string DecidedText(const Scene& scene) {
  const ModelOptions& model = scene.model;
  const Json json{{"kind", model.kind},
                  {"elements", model.elements},
                  {"modes", model.modes},
                  {"refinements", model.refinements},
                  {"residual", model.fem.residual},
                  {"order", static_cast<int>(model.order)},
                  {"element", static_cast<int>(model.fem.element)},
                  {"law", static_cast<int>(model.fem.law)},
                  {"cells", CellsOf(scene.object.geometry)},
                  {"decision", ToJson(model.decision)}};
  return json.dump(1) + "\n";
}

bool ApplyDecided(std::string_view text, Scene* scene) {
  const Json json = Json::parse(text, nullptr, false);
  if (!json.is_object()) return false;
  Scene decided = *scene;
  try {
    Read(json, &decided.model);
    ReadCells(json.at("cells"), &decided.object.geometry);
  } catch (const std::exception&) {  // torn, or of another version
    return false;
  }
  const std::string& kind = decided.model.kind;
  const bool fits = kind != "auto" && IsKindFor(ClassOf(decided.object.geometry), kind);
  if (!fits || decided.model.decision.reason.empty()) return false;
  *scene = std::move(decided);
  return true;
}

std::vector<std::string> LinesOf(const ModelDecision& decision, std::size_t most) {
  std::vector<std::string> lines{decision.reason};
  for (const RejectedModel& r : decision.rejected) {
    if (lines.size() > most) break;
    lines.push_back("not " + r.model + ": " + r.why + Figures(r));
  }
  const std::size_t listed = lines.size() - 1, all = decision.rejected.size();
  if (listed < all) lines.push_back(fmt::format("and {} more were not chosen", all - listed));
  return lines;
}

}  // namespace palpate
