// Results of a run without an operator: the rows of states.csv, keys of summary.json, and the error
// if a simulator provides the truth.
#pragma once

#include <cstdint>
#include <filesystem>
#include <fstream>
#include <limits>
#include <map>
#include <optional>
#include <stdexcept>
#include <string>
#include <vector>

#include <Eigen/Core>
#include <nlohmann/json.hpp>

#include "shared/state/slave_state.h"
#include "shared/state/validity.h"
#include "shared/telemetry/latency_histogram.h"
#include "slave/capture/ground_truth.h"
#include "slave/pipeline/base/sensing_pipeline.h"

namespace palpate {

// Split of the force error if a simulator provides the truth: the error of the model's force at the
// true indentation is the model's error, the rest is the error of sensing. The forces on one tool
// or fingertip in one sample, any one frame [N].
struct ComparedForces {
  Eigen::Vector3d estimated{0, 0, 0};  // not finite: unknown
  Eigen::Vector3d truth{0, 0, 0};
  // Magnitude of the model's force at the true indentation; NaN: none.
  double model_at_truth = std::numeric_limits<double>::quiet_NaN();
};

inline const Eigen::Vector3d kUnknownVector =
    Eigen::Vector3d::Constant(std::numeric_limits<double>::quiet_NaN());
// Size of the force that the master renders of `local` at this depth [m] below its plane [N].
inline double ForceAt(const LocalModel& local, double depth) {
  return (local.force + local.stiffness * local.normal * depth).norm();
}

// Errors over samples in contact.
struct ErrorBudget {
  std::uint64_t count = 0;
  double rms = 0;           // of the force's vector, estimated minus true [N]
  double peak_error = 0;    // of the same, the largest [N]
  double peak_force = 0;    // the largest true one [N]
  double model_rms = 0;     // of sizes: of the model at the true indentation, minus true [N]
  double tracking_rms = 0;  // of sizes: estimated, minus of the model at the true indentation [N]
};

// Samples in contact are those in which truth or estimate exceed 1 % of the true peak. Unknown
// forces cannot be compared.
ErrorBudget BudgetOf(const std::vector<ComparedForces>& compared);
// The entry of summary.json; null if no sample in contact was compared. `samples`: the name of the
// key that counts them, contact_`samples`.
nlohmann::ordered_json ToJson(const ErrorBudget& budget, const std::string& samples);

// Writes states.csv row by row. Frame S. Values that are absent or not finite are empty fields.
struct StateRow {
  double t = 0;  // [s]
  std::uint64_t sequence = 0;
  std::string finger;                    // empty: a camera's tool
  Eigen::Vector3d p_S_tip, p_S_contact;  // [m]
  std::optional<Eigen::Vector3d> force;  // of the object on the tool [N]
  double sigma = 0;                      // [N]; empty where the force is
  Validity validity = Validity::kFailed;
  FailedCheck check = FailedCheck::kNone;
  std::optional<Eigen::Vector3d> true_force;  // [N]; only where the file has its columns
  CheckDetails details;
  std::optional<Eigen::Vector3d> moment;  // about the tip [N m]
  double moment_sigma = 0;                // [N m]; empty where the moment is
};

// The estimate for a camera's tool; `start`: of the run.
StateRow RowOf(const ContactEstimate& estimate, Time start,
               const std::optional<Eigen::Vector3d>& true_force);

// Rows are flushed one by one, so that the file remains readable after a crash.
class StatesFile {
 public:
  // Creates `folder` if missing and FOLDER/states.csv in it, and removes an older summary.json.
  // Throws std::runtime_error: not writable.
  StatesFile(const std::filesystem::path& folder, bool has_truth);
  void Write(const StateRow& row);

 private:
  std::filesystem::path file_;
  bool has_truth_;
  std::ofstream stream_;
};

// Throws std::system_error naming the file.
void RequireWritten(bool written, const std::filesystem::path& file);

struct OfflineSummary {
  std::uint64_t frames = 0;                       // samples
  double seconds = 0;                             // wall clock, without precompute [s]
  std::uint64_t tracking_lost = 0;                // rows of states.csv
  std::map<std::string, std::uint64_t> validity;  // rows per validity
  std::map<std::string, std::uint64_t> checks;    // rows per failed check
  LatencyHistogram capture;
  std::vector<StageTimes> stages;  // those after `capture`
  bool has_truth = false;
  SenseInfo sense;
  ErrorBudget budget;              // of the force, if the truth is known
  nlohmann::ordered_json own;      // keys of this sense only
  std::vector<std::string> lines;  // further lines for people

  [[nodiscard]] double rate() const {  // [1/s]
    return seconds > 0 ? static_cast<double>(frames) / seconds : 0;
  }
};

class OfflineReport {
 public:
  virtual ~OfflineReport() = default;
  OfflineReport() = default;
  OfflineReport(const OfflineReport&) = delete;
  OfflineReport& operator=(const OfflineReport&) = delete;

  // The rows of the present estimate; `start`: of the run. `truth`: null if unknown.
  virtual std::vector<StateRow> Add(Time start, const Truth* truth) = 0;
  // Prepares `folder` for source samples; Write adds the newest one. Throw std::runtime_error: not
  // writable; std::invalid_argument: other samples are there.
  virtual void OpenFrames(const std::filesystem::path& /*folder*/) {}
  virtual void WriteFrame(const std::filesystem::path& /*folder*/) const {}
  // Makes Add write the tracked points from now on. Throws std::runtime_error: not writable;
  // std::invalid_argument: this sense follows none.
  virtual void OpenPoints(const std::filesystem::path& /*file*/) {
    throw std::invalid_argument("--points: only for a stereo pair or depth images");
  }
  // Throws std::runtime_error if `samples`, the number of all samples, are too few for an estimate.
  virtual void RequireComplete(std::uint64_t /*samples*/) const {}
  virtual void Finish(OfflineSummary* summary) const = 0;
  // The forces added so far, if the truth is known.
  [[nodiscard]] const std::vector<ComparedForces>& compared() const { return compared_; }

 protected:
  std::vector<ComparedForces> compared_;
};

}  // namespace palpate
