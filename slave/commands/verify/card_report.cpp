#include "slave/commands/verify/card_report.h"

#include <algorithm>
#include <array>

#include <nlohmann/json.hpp>

#include "shared/program/program.h"
#include "shared/text/html_page.h"
#include "shared/text/svg.h"
#include "shared/text/text.h"
#include "slave/commands/verify/card_words.h"

namespace palpate {
namespace {

using Json = nlohmann::ordered_json;

constexpr double kLeft = 70, kTop = 46, kSize = 320, kBelow = 56;
constexpr std::string_view kStyle = R"(
svg { font-family: system-ui, "DejaVu Sans", sans-serif; font-size: 12px; }
.paper { fill: #ffffff; } .ink { fill: #1d2430; } .soft { fill: #5b6576; }
.heading { font-size: 15px; font-weight: 600; } .frame { stroke: #8a94a6; }
.ideal { stroke: #8a94a6; stroke-dasharray: 4 4; } .bar { stroke-width: 1.5; }
.band { fill: #2f9e62; fill-opacity: 0.12; }
.s0 { fill: #d14545; stroke: #d14545; } .s1 { fill: #2f9e62; stroke: #2f9e62; }
.s2 { fill: #2f6fd6; stroke: #2f6fd6; }
)";
constexpr std::array<std::string_view, 3> kClasses{"s0", "s1", "s2"};

std::string NameOf(const ForceCard& card) {
  return card.finger.empty() ? "Tool" : "Fingertip " + card.finger;
}

// Known against reported force of every load, one colour for each axis, with two sigma.
std::string Draw(const ForceCard& card) {
  Svg svg(kLeft + kSize + 110, kTop + kSize + kBelow, "Known and reported force", kStyle);
  svg.Rectangle({0, 0}, {kLeft + kSize + 110, kTop + kSize + kBelow}, "paper");
  svg.Text({kLeft, 22}, NameOf(card) + ": reported force over known force", "ink heading");
  double most = 1e-12;
  for (const KnownAndReported& load : card.loads) {
    most = std::max({most, load.known.cwiseAbs().maxCoeff(), load.reported.cwiseAbs().maxCoeff()});
  }
  most *= 1.1;
  const auto at = [&](double known, double reported) {
    return Eigen::Vector2d(kLeft + kSize * (known / most + 1) / 2,
                           kTop + kSize * (1 - reported / most) / 2);
  };
  const double less = 1 - kForceTolerance, more = 1 + kForceTolerance, edge = most / more;
  for (const double side : {-edge, edge}) {
    svg.Polygon(std::array{at(0, 0), at(side, less * side), at(side, more * side)}, "band");
  }
  svg.Line(at(-most, -most), at(most, most), "ideal");
  svg.Line(at(-most, 0), at(most, 0), "frame");
  svg.Line(at(0, -most), at(0, most), "frame");
  for (const int axis : card.axes) {
    const auto& style = kClasses[static_cast<std::size_t>(axis)];
    for (const KnownAndReported& load : card.loads) {
      const double known = load.known(axis), told = load.reported(axis), bar = 2 * load.sigma;
      svg.Line(at(known, std::max(-most, told - bar)), at(known, std::min(most, told + bar)),
               std::string(style) + " bar");
      svg.Circle(at(known, told), 3, style);
    }
    const double y = kTop + 16 + 20 * axis;
    svg.Circle({kLeft + kSize + 18, y - 4}, 4, style);
    svg.Text({kLeft + kSize + 28, y},
             std::string("force ") + kAxisNames[static_cast<std::size_t>(axis)], "ink");
  }
  svg.Text({kLeft, kTop + kSize + 22},
           Formatted("known force, -%.3g to %.3g N; bars: 2 sigma; band: right", most, most),
           "soft");
  svg.Text({kLeft - 12, kTop + kSize / 2}, "reported", "soft", Svg::Anchor::kMiddle, -90);
  return svg.Document();
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
  const MapFit& fit = card.force;
  json["map"] = {{"reported_per_known", MatrixJson(fit.map)},
                 {"half_width", MatrixJson(fit.half_width)},
                 {"directions", fit.directions},
                 {"explained", fit.explained},
                 {"reported_axis", fit.relation.axis},
                 {"sign", fit.relation.sign}};
  return json;
}

void AddMap(const ForceCard& card, HtmlPage* page) {
  if (!card.force.is_decided) return;
  std::vector<std::vector<std::string>> rows;
  std::vector<std::string> head{"reported per known"};
  for (const int axis : card.axes) head.push_back(kAxisNames[static_cast<std::size_t>(axis)]);
  for (const int i : card.axes) {
    std::vector<std::string>& row =
        rows.emplace_back(std::vector<std::string>{kAxisNames[static_cast<std::size_t>(i)]});
    for (const int j : card.axes) {
      row.push_back(Formatted("%.3f ± %.3f", card.force.map(i, j), card.force.half_width(i, j)));
    }
  }
  page->Table(head, rows);
  if (card.force.directions < static_cast<int>(card.axes.size())) {
    page->Paragraph(
        Formatted("The loads act in %d of %zu directions. The map is that of these directions.",
                  card.force.directions, card.axes.size()));
  }
}

void AddCard(const ForceCard& card, HtmlPage* page) {
  page->Heading(NameOf(card) + ": " + (card.passes() ? "passes" : "does not pass"));
  page->Paragraph(Formatted("%zu loads, %d states compared, %d flagged by the slave's own checks.",
                            card.loads.size(), card.states, card.flagged));
  std::vector<std::vector<std::string>> rows;
  for (const CardLine& line : card.lines) {
    rows.push_back({line.title, std::string(ToString(line.finding)), line.value, line.remark});
  }
  page->Table({"quantity", "verdict", "value (95 % interval)", "meaning"}, rows);
  if (!card.causes.empty()) page->Heading("Likely wrong");
  for (const std::string& cause : card.causes) page->Paragraph(cause);
  page->Drawing(Draw(card));
  AddMap(card, page);
}

}  // namespace

void WriteCards(const CardTitle& title, const std::vector<ForceCard>& cards,
                const std::filesystem::path& folder) {
  const bool passes = std::ranges::all_of(cards, &ForceCard::passes);
  HtmlPage page("Force test card: " + title.scene);
  page.Paragraph(std::string(passes ? "Passes." : "Does not pass.") + " States: " + title.source +
                 ". palpate " + Version() + ".");
  Json json{{"scene", title.scene},
            {"source", title.source},
            {"version", Version()},
            {"passes", passes},
            {"cards", Json::array()}};
  for (const ForceCard& card : cards) {
    AddCard(card, &page);
    json["cards"].push_back(ToJson(card));
  }
  WriteWholeFile(folder / "report.html", page.Document());
  WriteWholeFile(folder / "report.json", json.dump(2) + "\n");
}

void WriteRefusal(const std::string& scene, const std::string& why,
                  const std::filesystem::path& folder) {
  HtmlPage page("Force test card: " + scene);
  page.Paragraph("Does not pass. The slave refuses these samples:");
  page.Paragraph(why);
  const Json json{{"scene", scene},
                  {"version", Version()},
                  {"passes", false},
                  {"refused", why},
                  {"cards", Json::array()}};
  WriteWholeFile(folder / "report.html", page.Document());
  WriteWholeFile(folder / "report.json", json.dump(2) + "\n");
}

std::string ToText(const std::vector<ForceCard>& cards) {
  std::string text;
  for (const ForceCard& card : cards) {
    text += Formatted("%s: %s, %zu loads, %d states\n", NameOf(card).c_str(),
                      card.passes() ? "passes" : "does not pass", card.loads.size(), card.states);
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
