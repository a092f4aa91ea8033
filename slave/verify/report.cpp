#include "slave/verify/report.h"

#include <algorithm>
#include <optional>

#include <nlohmann/json.hpp>

#include "shared/program/program.h"
#include "shared/text/text.h"

namespace palpate {
namespace {

using Json = nlohmann::ordered_json;

Json IntervalJson(const std::optional<Interval>& interval) {
  if (!interval) return nullptr;
  return {interval->low, interval->value, interval->high};
}

Json MatrixJson(const Eigen::Matrix3d& matrix) {
  Json rows = Json::array();
  for (int i = 0; i < 3; ++i) rows.push_back({matrix(i, 0), matrix(i, 1), matrix(i, 2)});
  return rows;
}

Json ToJson(const std::string& finger, const ForceComparison& one) {
  Json json{{"finger", finger},           {"passes", one.passes()}, {"states", one.rows},
            {"flagged", one.flagged},     {"loads", one.holds},     {"lines", Json::object()},
            {"likely_wrong", one.causes}, {"unit", one.unit}};
  for (const ComparisonLine& line : one.lines) {
    json["lines"][line.key] = {{"verdict", ToString(line.finding)},
                               {"low_value_high", IntervalJson(line.interval)},
                               {"text", line.value},
                               {"remark", line.remark}};
  }
  json["map"] = {{"reported_per_known", MatrixJson(one.map.map)},
                 {"half_width", MatrixJson(one.map.half_width)},
                 {"directions", one.map.directions},
                 {"explained", one.map.explained},
                 {"reported_axis", one.map.relation.axis},
                 {"sign", one.map.relation.sign}};
  return json;
}

}  // namespace

std::string ToJson(const std::string& scene, const std::string& source,
                   const Comparisons& comparisons) {
  Json json{{"scene", scene},
            {"source", source},
            {"version", Version()},
            {"passes", Pass(comparisons)},
            {"cards", Json::array()}};
  for (const auto& [finger, one] : comparisons) json["cards"].push_back(ToJson(finger, one));
  return json.dump(2) + "\n";
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

std::string ToText(const Comparisons& comparisons) {
  std::string text;
  for (const auto& [finger, one] : comparisons) {
    text += (finger.empty() ? "Tool" : "Fingertip " + finger) +
            (one.passes() ? ": passes, " : ": does not pass, ");
    if (one.holds > 0) text += Formatted("%d loads, ", one.holds);
    text += Formatted("%d states under load\n", one.rows);
    for (const ComparisonLine& line : one.lines) {
      text += Formatted("  %-20s  %-11s  %s\n", line.title.c_str(),
                        std::string(ToString(line.finding)).c_str(),
                        (line.value.empty() ? line.remark : line.value).c_str());
    }
    for (const std::string& cause : one.causes) text += "likely wrong: " + cause + "\n";
  }
  return text;
}

bool Pass(const Comparisons& comparisons) {
  return std::ranges::all_of(comparisons, [](const auto& one) { return one.second.passes(); });
}

}  // namespace palpate
