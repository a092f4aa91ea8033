// The budget as a table, as JSON and as a drawing.
#include <algorithm>
#include <filesystem>

#include <nlohmann/json.hpp>
#include <spdlog/fmt/fmt.h>

#include "shared/text/text.h"
#include "slave/commands/study/end_to_end.h"
#include "slave/pipeline/base/sensing_pipeline.h"
#include "slave/report/svg.h"

namespace palpate {
namespace {

using Eigen::Vector2d;

constexpr double kWidth = 760, kLeft = 110, kBar = 380, kRow = 34, kTop = 84;
constexpr std::string_view kStyle = R"(
svg { font-family: system-ui, "DejaVu Sans", sans-serif; font-size: 13px; }
.paper { fill: #ffffff; } .ink { fill: #1d2430; } .soft { fill: #5b6576; }
.heading { font-size: 16px; font-weight: 600; } .small { font-size: 11px; }
.part { fill: #2f6fd6; } .largest { fill: #d6336c; } .stated { fill-opacity: 0.45; }
@media (prefers-color-scheme: dark) {
.paper { fill: #14181f; } .ink { fill: #e8ecf2; } .soft { fill: #a9b3c2; }
.part { fill: #6ea4ff; } .largest { fill: #ff6b9a; } }
)";

std::string InWords(const EndToEndBudget& budget, double force) {
  return fmt::format("{:.2f} % of the peak ({:.2g} N)",
                     budget.peak > 0 ? 100 * force / budget.peak : 0, force);
}

// Mean and spread of one part.
std::string InWords(const EndToEndBudget& budget, const BudgetPart& part) {
  std::string words = InWords(budget, part.rms);
  if (budget.presses > 1 && budget.peak > 0) {
    words += fmt::format(", {:.2f} to {:.2f} %", 100 * part.least / budget.peak,
                         100 * part.most / budget.peak);
  }
  return words + (part.is_stated ? ", as stated in the scene" : "");
}

std::string Sentence(const EndToEndBudget& budget) {
  const BudgetPart& largest = budget.largest();
  return fmt::format("the largest part is {}; it is reduced by {}", largest.name, largest.lowers);
}

std::string Draw(const EndToEndBudget& budget) {
  const double height = kTop + kRow * static_cast<double>(budget.parts.size()) + 56;
  Svg svg(kWidth, height, "Error budget of the rendered force: " + budget.scene, kStyle);
  svg.Rectangle({0, 0}, {kWidth, height}, "paper");
  svg.Text({20, 28}, budget.scene + ": error budget of the rendered force", "ink heading");
  svg.Text(
      {20, 50},
      fmt::format("rms during {} scripted contacts, peak {:.3g} N, link {:g} ms; total {}",
                  budget.presses, budget.peak, 1e3 * budget.delay, InWords(budget, budget.total)),
      "soft");
  const double most = std::max(budget.largest().rms, 1e-300);
  double y = kTop;
  for (const BudgetPart& part : budget.parts) {
    const bool is_largest = &part == &budget.largest();
    svg.Text({kLeft - 10, y + 14}, part.name, "ink", Svg::Anchor::kEnd);
    const double length = std::max(1.0, kBar * part.rms / most);
    const std::string style = is_largest ? "largest" : "part";
    svg.Rectangle({kLeft, y}, {length, 20}, style + (part.is_stated ? " stated" : ""));
    svg.Text({kLeft + length + 8, y + 14}, InWords(budget, part), "ink small");
    y += kRow;
  }
  svg.Text({20, y + 20}, Sentence(budget), "ink");
  return svg.Document();
}

}  // namespace

std::string ToTable(const EndToEndBudget& budget) {
  std::string text = fmt::format("{}: {} presses, peak {:.3g} N, link {:g} ms\n", budget.scene,
                                 budget.presses, budget.peak, 1e3 * budget.delay);
  for (const BudgetPart& part : budget.parts) {
    text += fmt::format("  {:<10} {}\n", part.name, InWords(budget, part));
  }
  return text +
         fmt::format("  {:<10} {}\n{}\n", "total", InWords(budget, budget.total), Sentence(budget));
}

void WriteBudget(const EndToEndBudget& budget, const std::filesystem::path& folder) {
  nlohmann::ordered_json json{{"scene", budget.scene},
                              {"presses", budget.presses},
                              {"peak_N", budget.peak},
                              {"delay_s", budget.delay},
                              {"total_rms_N", budget.total},
                              {"largest", budget.largest().name},
                              {"lowers", budget.largest().lowers}};
  for (const BudgetPart& part : budget.parts) {
    json["parts_rms_N"][part.name] = part.rms;
    json["parts_spread_N"][part.name] = {part.least, part.most};
  }
  WriteWholeFile(folder / "end_to_end.json", json.dump(2) + "\n");
  WriteWholeFile(folder / "end_to_end.svg", Draw(budget));
}

}  // namespace palpate
