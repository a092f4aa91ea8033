// What a run without an operator keeps of one sense: the rows of states.csv, its own keys of
// summary.json, and how far it was from the truth where the site knows it.
#pragma once

#include <cstdint>
#include <filesystem>
#include <map>
#include <string>
#include <vector>

#include <nlohmann/json.hpp>

#include "shared/telemetry/latency_histogram.h"
#include "slave/pipeline/offline/error_budget.h"
#include "slave/pipeline/offline/states_file.h"
#include "slave/pipeline/sense.h"

namespace palpate {

struct OfflineSummary {
  std::uint64_t frames = 0;                       // samples
  double seconds = 0;                             // wall clock, without precompute [s]
  std::uint64_t tracking_lost = 0;                // rows of states.csv
  std::map<std::string, std::uint64_t> validity;  // rows per validity
  LatencyHistogram capture;
  std::vector<StageTimes> stages;  // those after `capture`
  bool has_truth = false;
  SenseInfo sense;
  ErrorBudget budget;              // of the force, where the truth is known
  nlohmann::ordered_json own;      // keys of this sense only
  std::vector<std::string> lines;  // what is to be said besides, for people

  [[nodiscard]] double rate() const;  // [1/s]
};

class Account {
 public:
  virtual ~Account() = default;
  Account() = default;
  Account(const Account&) = delete;
  Account& operator=(const Account&) = delete;

  // The rows of the estimate just made; `start`: of the run. `truth`: null where nobody knows it.
  virtual std::vector<StateRow> Add(Time start, const Truth* truth) = 0;
  // Makes room in `folder` for samples as they came; Write adds the newest one. Throw
  // std::runtime_error: not writable; std::invalid_argument: other samples are there.
  virtual void OpenFrames(const std::filesystem::path& /*folder*/) {}
  virtual void WriteFrame(const std::filesystem::path& /*folder*/) const {}
  // Throws std::runtime_error where `samples`, all there were, are too few to say anything.
  virtual void RequireComplete(std::uint64_t /*samples*/) const {}
  virtual void Finish(OfflineSummary* summary) const = 0;
  // The forces added so far, where the truth is known.
  [[nodiscard]] const std::vector<ComparedForces>& compared() const { return compared_; }

 protected:
  std::vector<ComparedForces> compared_;
};

}  // namespace palpate
