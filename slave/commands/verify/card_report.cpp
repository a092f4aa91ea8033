#include "slave/commands/verify/card_report.h"

#include <algorithm>

#include <nlohmann/json.hpp>

#include "shared/program/program.h"
#include "shared/text/text.h"

namespace palpate {
namespace {

using Json = nlohmann::ordered_json;

std::string NameOf(const ForceCard& card) {
  return card.finger.empty() ? "Tool" : "Fingertip " + card.finger;
}

Json IntervalJson(const std::optional<Interval>& interval) {
  if (!interval) return nullptr;
  return {interval->low, interval->value, interval->high};
}

Json MatrixJson(const Eigen::Matrix3d& matrix) {
  Json rows = Json::array();
  for (int i = 0; i < 3; ++i) rows.push_back({matrix(i, 0), matrix(i, 1), matrix(i, 2)});
  return rows;
}

Json ToJson(const ForceCard& card) {
  Json json{{"finger", card.finger},      {"passes", card.passes()},    {"states", card.states},
            {"flagged", card.flagged},    {"loads", card.loads.size()}, {"lines", Json::object()},
            {"likely_wrong", card.causes}};
  for (const CardLine& line : card.lines) {
    json["lines"][line.key] = {{"verdict", ToString(line.finding)},
                               {"low_value_high", IntervalJson(line.interval)},
                               {"text", line.value},
                               {"remark", line.remark}};
  }
  json["unit"] = card.unit;
  const MapFit& fit = card.force;
  json["map"] = {{"reported_per_known", MatrixJson(fit.map)},
                 {"half_width", MatrixJson(fit.half_width)},
                 {"directions", fit.directions},
                 {"explained", fit.explained},
                 {"reported_axis", fit.relation.axis},
                 {"sign", fit.relation.sign}};
  return json;
}

}  // namespace

void WriteCards(const CardTitle& title, const std::vector<ForceCard>& cards,
                const std::filesystem::path& folder) {
  Json json{{"scene", title.scene},
            {"source", title.source},
            {"version", Version()},
            {"passes", std::ranges::all_of(cards, &ForceCard::passes)},
            {"cards", Json::array()}};
  for (const ForceCard& card : cards) json["cards"].push_back(ToJson(card));
  WriteWholeFile(folder / "report.json", json.dump(2) + "\n");
}

void WriteRefusal(const std::string& scene, const std::string& why,
                  const std::filesystem::path& folder) {
  const Json json{{"scene", scene},
                  {"version", Version()},
                  {"passes", false},
                  {"refused", why},
                  {"cards", Json::array()}};
  WriteWholeFile(folder / "report.json", json.dump(2) + "\n");
}

std::string ToText(const std::vector<ForceCard>& cards) {
  std::string text;
  for (const ForceCard& card : cards) {
    text += Formatted("%s: %s, ", NameOf(card).c_str(), card.passes() ? "passes" : "does not pass");
    if (!card.loads.empty()) text += Formatted("%zu loads, ", card.loads.size());
    text += Formatted("%d states under load\n", card.states);
    for (const CardLine& line : card.lines) {
      text += Formatted("  %-20s  %-11s  %s\n", line.title.c_str(),
                        std::string(ToString(line.finding)).c_str(),
                        (line.value.empty() ? line.remark : line.value).c_str());
    }
    for (const std::string& cause : card.causes) text += "likely wrong: " + cause + "\n";
  }
  return text;
}

}  // namespace palpate
