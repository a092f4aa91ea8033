#include "slave/study/report.h"

#include <algorithm>
#include <cmath>
#include <cstdio>
#include <vector>

#include "shared/text/csv.h"
#include "shared/text/text.h"
#include "slave/study/figure.h"

namespace palpate::study {
namespace {

constexpr int kDigits = 17;

// Quoted where a comma, a quote or a line end would break the line.
std::string Cell(const std::string& text) {
  if (text.find_first_of(",\"\n\r") == std::string::npos) return text;
  std::string quoted = "\"";
  for (const char c : text) {
    if (c == '"') quoted += '"';
    quoted += c == '\n' || c == '\r' ? ' ' : c;
  }
  return quoted + "\"";
}

std::string Seconds(double s) {
  if (!std::isfinite(s)) return "";
  char text[40];
  const auto [scale, unit] = s < 1e-3  ? std::pair(1e6, "us")
                             : s < 1.0 ? std::pair(1e3, "ms")
                                       : std::pair(1.0, "s");
  std::snprintf(text, sizeof text, "%.3g %s", scale * s, unit);
  return text;
}

std::string Percent(const Estimate& error) {
  if (!std::isfinite(error.value)) return "";
  char text[60];
  std::snprintf(text, sizeof text, "%.2g +- %.1g %%", 100 * error.value, 100 * error.bar);
  return text;
}

std::string Marks(const StudyRow& row) {
  std::string marks = row.on_front ? "front" : "";
  if (row.meets_tolerance && row.meets_rate) marks += marks.empty() ? "meets" : ", meets";
  if (row.recommended) marks += marks.empty() ? "RECOMMENDED" : ", RECOMMENDED";
  return marks;
}

std::string TableLine(const std::vector<std::string>& cells) {
  constexpr int kWidths[] = {28, 20, 9, 9, 18, 11, 11, 11, 9, 0};
  std::string line;
  for (std::size_t i = 0; i < cells.size(); ++i) {
    line += cells[i];
    const auto width = static_cast<std::size_t>(kWidths[i]);
    line.append(cells[i].size() < width ? width - cells[i].size() : 1, ' ');
  }
  line.erase(line.find_last_not_of(' ') + 1);
  return line + "\n";
}

std::string ResidualOf(const StudyRow& row) {
  char text[40];
  std::snprintf(text, sizeof text, "%.0e", row.residual);
  return row.residual > 0 ? text : "";
}

}  // namespace

std::string ToCsv(const StudyResult& study) {
  std::string csv =
      "family,kind,resolution,dof,residual,outcome,error,error_bar,error_small,error_small_bar,"
      "deviation,width_error,validity,update_median_s,update_p99_s,precompute_s,memory_bytes,"
      "expected_s,on_front,"
      "meets_tolerance,meets_rate,recommended,reason\n";
  for (const StudyRow& row : study.rows) {
    const auto number = [&](double value) {
      AppendNumber(&csv, value, kDigits);
      csv += ',';
    };
    const auto flag = [&](bool value) { csv += value ? "1," : "0,"; };
    csv += Cell(row.family) + "," + row.kind + "," + Cell(row.resolution) + "," +
           std::to_string(row.dof) + ",";
    number(row.residual > 0 ? row.residual : kUnknown);
    csv += std::string(ToString(row.outcome)) + ",";
    for (const Estimate& e : {row.error, row.error_small}) number(e.value), number(e.bar);
    number(row.deviation);
    number(row.width_error);
    csv += row.outcome == Outcome::kAnswered ? std::string(ToString(row.validity)) + "," : ",";
    number(row.update_median_s);
    number(row.update_p99_s);
    number(row.precompute_s);
    csv += std::to_string(row.memory_bytes) + ",";
    number(row.expected_s);
    flag(row.on_front), flag(row.meets_tolerance), flag(row.meets_rate), flag(row.recommended);
    csv += Cell(row.reason) + "\n";
  }
  return csv;
}

std::string ToTable(const StudyResult& study) {
  std::string table = TableLine(
      {"model", "resolution", "residual", "dof", "error", "update", "p99", "precompute", "MB", ""});
  std::vector<const StudyRow*> answered;
  for (const StudyRow& row : study.rows) {
    if (row.outcome == Outcome::kAnswered) answered.push_back(&row);
  }
  std::ranges::stable_sort(answered, {}, [](const StudyRow* row) { return row->update_median_s; });
  for (const StudyRow* row : answered) {
    char mega[32];
    std::snprintf(mega, sizeof mega, "%.3g", 1e-6 * static_cast<double>(row->memory_bytes));
    table += TableLine({row->family, row->resolution, ResidualOf(*row), std::to_string(row->dof),
                        Percent(row->error), Seconds(row->update_median_s),
                        Seconds(row->update_p99_s), Seconds(row->precompute_s), mega, Marks(*row)});
  }
  for (const StudyRow& row : study.rows) {
    if (row.outcome == Outcome::kAnswered) continue;
    table += "  " + std::string(ToString(row.outcome)) + ": " + row.family + ", " + row.resolution +
             (row.residual > 0 ? ", residual " + ResidualOf(row) : "") + " (expected " +
             Seconds(row.expected_s) + "): " + row.reason + "\n";
  }
  table += "\n";
  for (const Reference& reference : study.references.presses) {
    table += "reference: " + reference.source + "\n";
  }
  if (!study.references.remark.empty()) table += "note: " + study.references.remark + "\n";
  return table + "recommended: " + study.recommendation + "\n";
}

void WriteStudy(const StudyResult& study, const std::filesystem::path& folder) {
  ReplaceFile(folder / "study.csv", ToCsv(study));
  ReplaceFile(folder / "study.json", ToJson(study));
  ReplaceFile(folder / "study.svg", DrawFigure(study));
}

}  // namespace palpate::study
