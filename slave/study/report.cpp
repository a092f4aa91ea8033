#include "slave/study/report.h"

#include <algorithm>
#include <cmath>
#include <map>
#include <string>
#include <vector>

#include <nlohmann/json.hpp>

#include "shared/text/csv.h"
#include "shared/text/text.h"
#include "shared/wire/enum_names.h"
#include "slave/scene/model_kinds.h"

namespace palpate::study {
namespace {

using Json = nlohmann::ordered_json;

Json ToJson(const Eigen::Vector3d& v) {
  return {v.x(), v.y(), v.z()};
}

Json ToJson(const Estimate& e) {
  return {{"value", e.value}, {"bar", e.bar}};
}

Json ToJson(const Answer& answer) {
  return {{"value", answer.value}, {"validity", ToString(answer.validity)}};
}

Json ToJson(const PressSpec& question) {
  Json json{{"width_m", question.width},
            {"depth_m", question.depth},
            {"small_depth_m", question.small_depth},
            {"size_m", question.size},
            {"load_N", question.load},
            {"presses", Json::array()}};
  for (const Press& press : question.presses) {
    json["presses"].push_back({{"p_O_m", ToJson(press.p_O)},
                               {"inward_O", ToJson(press.inward_O)},
                               {"tool", press.loaded ? "even pressure" : "rigid patch"}});
  }
  return json;
}

Json ToJson(const References& references) {
  Json json{{"remark", references.remark}, {"presses", Json::array()}};
  for (const Reference& reference : references.presses) {
    json["presses"].push_back({{"source", reference.source},
                               {"small", ToJson(reference.small)},
                               {"full", ToJson(reference.full)}});
  }
  return json;
}

Json ToJson(const StudyRow& row) {
  Json json{{"number", row.number},
            {"family", row.family},
            {"kind", row.kind},
            {"resolution", row.resolution},
            {"element_size_m", row.element_size},
            {"dof", row.dof},
            {"residual", row.residual > 0 ? row.residual : kUnknown},
            {"outcome", ToString(row.outcome)},
            {"reason", row.reason},
            {"error", ToJson(row.error)},
            {"error_small", ToJson(row.error_small)},
            {"deviation", row.deviation},
            {"plane_error", row.plane_error},
            {"validity", ToString(row.validity)},
            {"beyond", row.beyond},
            {"own", row.own_model},
            {"update_s", {{"median", row.update_median_s}, {"p99", row.update_p99_s}}},
            {"precompute_s", row.precompute_s},
            {"memory_bytes", row.memory_bytes},
            {"expected_s", row.expected_s},
            {"on_front", row.on_front},
            {"meets_tolerance", row.meets_tolerance},
            {"meets_rate", row.meets_rate},
            {"recommended", row.recommended},
            {"answers", Json::array()}};
  for (const PressAnswers& a : row.answers) {
    json["answers"].push_back({{"small", ToJson(a.small)}, {"full", ToJson(a.full)}});
  }
  return json;
}

constexpr int kDigits = 17;

// Returns the text, in quotes if it contains a comma, a quote or a line end.
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
  const auto [scale, unit] = s < 1e-3  ? std::pair(1e6, "us")
                             : s < 1.0 ? std::pair(1e3, "ms")
                                       : std::pair(1.0, "s");
  return Formatted("%.3g %s", scale * s, unit);
}

std::string Percent(const Estimate& error) {
  if (!std::isfinite(error.value)) return "";
  return Formatted("%.2g +- %.1g %%", 100 * error.value, 100 * error.bar);
}

std::string Marks(const StudyRow& row) {
  if (!row.selectable) return "for the reference";
  std::string marks = row.own_model ? "own" : "";
  if (row.on_front) marks += marks.empty() ? "front" : ", front";
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

const char* WordOf(ElementOrder order) {
  return order == ElementOrder::kConstant ? "constant"
         : order == ElementOrder::kLinear ? "linear"
                                          : "quadratic";
}

const char* WordOf(FemOptions::Law law) {
  return law == FemOptions::Law::kCorotational ? "corotational"
         : law == FemOptions::Law::kLinear     ? "linear"
                                               : "neo-hookean";
}

// Returns the keys that give a scene this model.
std::string KeysOf(const StudyRow& row) {
  const ModelKind* kind = FindModelKind(row.kind);
  std::string keys = "model: {kind: " + row.kind;
  if (kind != nullptr && kind->is_plane) {
    keys += Formatted(", elements: %d, order: %s", row.model.elements, WordOf(row.model.order));
  }
  if (kind != nullptr && kind->has_tets) {
    const bool quadratic = row.model.fem.element == FemOptions::Element::kTet10;
    keys += quadratic ? ", element: tet10" : ", element: tet4";
  }
  // The constants of Ogden's law are the scene's own.
  if (row.residual > 0 && row.model.fem.law != FemOptions::Law::kOgden) {
    keys += Formatted(", law: %s, residual: %g", WordOf(row.model.fem.law), row.residual);
  }
  keys += "}";
  const auto [i, j, k] = row.cells;
  if (i > 0) keys += Formatted("; object: {geometry: {box: {cells: [%d, %d, %d]}}}", i, j, k);
  if (row.model.refinements > 0 && i == 0) {
    keys += row.model.refinements == 1 ? "; edges of the mesh halved once"
                                       : "; edges of the mesh halved twice";
  }
  return keys;
}

std::string ResidualOf(const StudyRow& row) {
  return row.residual > 0 ? Formatted("%.0e", row.residual) : "";
}

}  // namespace

std::string ToJson(const StudyResult& study) {
  Json json{
      {"scene", study.scene_name},
      {"question", ToJson(study.question)},
      {"settings",
       {{"tolerance", study.tolerance}, {"rate_Hz", study.rate}, {"budget_s", study.budget_s}}},
      {"complete", study.complete},
      {"recommendation", study.recommendation},
      {"references", ToJson(study.references)},
      {"rows", Json::array()}};
  for (const StudyRow& row : study.rows) json["rows"].push_back(ToJson(row));
  // Numbers that are not finite become null. A name that is not UTF-8 becomes readable and causes
  // no exception.
  return json.dump(1, ' ', false, Json::error_handler_t::replace) + "\n";
}

std::string ToCsv(const StudyResult& study) {
  std::string csv =
      "family,kind,resolution,dof,residual,outcome,error,error_bar,error_small,error_small_bar,"
      "deviation,plane_error,validity,update_median_s,update_p99_s,precompute_s,memory_"
      "bytes,"
      "expected_s,own,on_front,"
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
    number(row.plane_error);
    csv += row.outcome == Outcome::kAnswered ? std::string(ToString(row.validity)) + "," : ",";
    number(row.update_median_s);
    number(row.update_p99_s);
    number(row.precompute_s);
    csv += std::to_string(row.memory_bytes) + ",";
    number(row.expected_s);
    flag(row.own_model), flag(row.on_front), flag(row.meets_tolerance), flag(row.meets_rate),
        flag(row.recommended);
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
    const auto mega = Formatted("%.3g", 1e-6 * static_cast<double>(row->memory_bytes));
    table += TableLine({row->family, row->resolution, ResidualOf(*row), std::to_string(row->dof),
                        Percent(row->error), Seconds(row->update_median_s),
                        Seconds(row->update_p99_s), Seconds(row->precompute_s), mega, Marks(*row)});
  }
  for (const StudyRow& row : study.rows) {
    if (row.outcome == Outcome::kAnswered) continue;
    table += "  " + std::string(ToString(row.outcome)) + ": " + row.name() +
             (row.residual > 0 ? ", residual " + ResidualOf(row) : "") + " (expected " +
             Seconds(row.expected_s) + "): " + row.reason + "\n";
  }
  table += "\n";
  std::map<std::string, int> sources;
  for (const Reference& reference : study.references.presses) ++sources[reference.source];
  for (const auto& [source, places] : sources) {
    table += "reference: " + source;
    table += places > 1 ? " (" + std::to_string(places) + " places)\n" : "\n";
  }
  if (!study.references.remark.empty()) table += "note: " + study.references.remark + "\n";
  table += "recommended: " + study.recommendation + "\n";
  for (const StudyRow& row : study.rows) {
    if (row.recommended) table += "keys of the scene: " + KeysOf(row) + "\n";
  }
  return table;
}

void WriteStudy(const StudyResult& study, const std::filesystem::path& folder) {
  ReplaceFile(folder / "study.csv", ToCsv(study));
  ReplaceFile(folder / "study.json", ToJson(study));
}

}  // namespace palpate::study
