#include <cmath>

#include <nlohmann/json.hpp>

#include "slave/study/report.h"

namespace palpate::study {
namespace {

using Json = nlohmann::ordered_json;

Json NumberOrNull(double value) {
  return std::isfinite(value) ? Json(value) : Json(nullptr);
}

Json ToJson(const Eigen::Vector3d& v) {
  return {v.x(), v.y(), v.z()};
}

Json ToJson(const Estimate& e) {
  return {{"value", NumberOrNull(e.value)}, {"bar", NumberOrNull(e.bar)}};
}

Json ToJson(const Answer& answer) {
  return {{"value", NumberOrNull(answer.value)}, {"validity", ToString(answer.validity)}};
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
  Json json{
      {"family", row.family},
      {"kind", row.kind},
      {"resolution", row.resolution},
      {"element_size_m", row.element_size},
      {"dof", row.dof},
      {"residual", NumberOrNull(row.residual > 0 ? row.residual : kUnknown)},
      {"outcome", ToString(row.outcome)},
      {"reason", row.reason},
      {"error", ToJson(row.error)},
      {"error_small", ToJson(row.error_small)},
      {"deviation", NumberOrNull(row.deviation)},
      {"width_error", NumberOrNull(row.width_error)},
      {"validity", ToString(row.validity)},
      {"update_s",
       {{"median", NumberOrNull(row.update_median_s)}, {"p99", NumberOrNull(row.update_p99_s)}}},
      {"precompute_s", NumberOrNull(row.precompute_s)},
      {"memory_bytes", row.memory_bytes},
      {"expected_s", row.expected_s},
      {"on_front", row.on_front},
      {"meets_tolerance", row.meets_tolerance},
      {"meets_rate", row.meets_rate},
      {"recommended", row.recommended},
      {"answers", Json::array()}};
  for (const PressAnswers& a : row.answers) {
    json["answers"].push_back({{"small", ToJson(a.small)},
                               {"full", ToJson(a.full)},
                               {"width_mismatch", NumberOrNull(a.width_mismatch)},
                               {"width_slope", NumberOrNull(a.width_slope)}});
  }
  return json;
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
  // A name that is not UTF-8 becomes readable, never an exception.
  return json.dump(1, ' ', false, Json::error_handler_t::replace) + "\n";
}

}  // namespace palpate::study
