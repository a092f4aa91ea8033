#include "slave/pipeline/offline/run_summary.h"

#include <fstream>

#include <nlohmann/json.hpp>

#include "slave/pipeline/offline/states_file.h"

namespace palpate {
namespace {

// [us]
nlohmann::ordered_json StageJson(const LatencyHistogram& h) {
  return {{"p50", h.Quantile(0.5)}, {"p99", h.Quantile(0.99)}, {"max", h.max()}};
}

}  // namespace

void RunSummary::Count(Validity row) {
  ++validity[std::string(ToString(row))];
  if (row == Validity::kTrackingLost) ++tracking_lost;
}

double RunSummary::rate() const {
  return seconds > 0 ? static_cast<double>(frames) / seconds : 0;
}

nlohmann::ordered_json ToJson(const ErrorBudget& budget) {
  if (budget.count() == 0) return nullptr;
  return {{"rms_N", budget.rms()},
          {"peak_N", budget.peak_error()},
          {"contact_frames", budget.count()},
          {"true_peak_N", budget.peak_force()},
          {"model_rms_N", budget.model_rms()},
          {"tracking_rms_N", budget.tracking_rms()}};
}

nlohmann::ordered_json SummaryJson(const RunSummary& summary, const std::string& scene,
                                   const std::vector<NamedStage>& stages,
                                   const nlohmann::ordered_json& force_error) {
  nlohmann::ordered_json json;
  json["scene"] = scene;
  json["frames"] = summary.frames;
  json["fps"] = summary.rate();
  json["stages"]["capture"] = StageJson(summary.capture);
  for (const NamedStage& stage : stages) json["stages"][stage.name] = StageJson(stage.times);
  json["tracking_lost"] = summary.tracking_lost;
  json["force_error"] = force_error;
  json["validity"] = summary.validity;
  json["model"] = {{"kind", summary.model.kind},
                   {"elements", summary.model.elements},
                   {"dof", summary.model.dof},
                   {"precompute_s", summary.model.precompute_s}};
  return json;
}

void WriteJson(const nlohmann::ordered_json& json, const std::filesystem::path& file) {
  RequireWritten((std::ofstream(file) << json.dump(2) << "\n" << std::flush).good(), file);
}

}  // namespace palpate
