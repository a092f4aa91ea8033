// What every run without an operator comes to, and the lines of summary.json that all have
// (contracts: reports).
#pragma once

#include <cstdint>
#include <filesystem>
#include <map>
#include <string>
#include <vector>

#include <nlohmann/json_fwd.hpp>

#include "shared/state/validity.h"
#include "shared/telemetry/latency_histogram.h"
#include "slave/mechanics/deformation_model.h"
#include "slave/pipeline/offline/error_budget.h"

namespace palpate {

struct RunSummary {
  std::uint64_t frames = 0;
  double seconds = 0;                             // wall clock, without precompute [s]
  std::uint64_t tracking_lost = 0;                // rows of states.csv
  std::map<std::string, std::uint64_t> validity;  // rows per validity
  LatencyHistogram capture;
  bool has_truth = false;
  ModelInfo model;

  // One row of states.csv.
  void Count(Validity row);
  [[nodiscard]] double rate() const;  // [1/s]
};

struct NamedStage {
  std::string name;
  const LatencyHistogram& times;
};

// null where no picture in contact was compared.
nlohmann::ordered_json ToJson(const ErrorBudget& budget);
// `stages`: those after `capture`. `force_error`: null without a truth, or where nothing was
// compared with it.
nlohmann::ordered_json SummaryJson(const RunSummary& summary, const std::string& scene,
                                   const std::vector<NamedStage>& stages,
                                   const nlohmann::ordered_json& force_error);
// Throws std::runtime_error naming the file.
void WriteJson(const nlohmann::ordered_json& json, const std::filesystem::path& file);

}  // namespace palpate
