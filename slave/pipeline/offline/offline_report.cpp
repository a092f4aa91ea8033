#include "slave/pipeline/offline/offline_report.h"

#include <cerrno>
#include <cmath>
#include <stdexcept>
#include <system_error>

#include <nlohmann/json.hpp>
#include <spdlog/fmt/fmt.h>

#include "shared/wire/enum_names.h"

namespace palpate {
namespace {

constexpr double kContactShare = 0.01;  // of the true peak

std::string Number(double x) {
  return std::isfinite(x) ? fmt::format("{:.9g}", x) : "";
}

// Returns the numbers, each preceded by a comma.
std::string Numbers(const Eigen::Vector3d& v) {
  return fmt::format(",{},{},{}", Number(v.x()), Number(v.y()), Number(v.z()));
}

}  // namespace

ErrorBudget BudgetOf(const std::vector<ComparedForces>& compared) {
  ErrorBudget budget;
  for (const ComparedForces& c : compared) {
    budget.peak_force = std::fmax(budget.peak_force, c.truth.norm());
  }
  double total = 0, model = 0, tracking = 0;  // sums of squares [N^2]
  std::uint64_t modelled = 0;
  for (const ComparedForces& c : compared) {
    const double estimated = c.estimated.norm(), truth = c.truth.norm();
    const bool touches = std::fmax(estimated, truth) > kContactShare * budget.peak_force;
    if (!touches || !std::isfinite(estimated)) continue;
    const double error = (c.estimated - c.truth).norm();
    ++budget.count;
    total += error * error;
    budget.peak_error = std::fmax(budget.peak_error, error);
    if (!std::isfinite(c.model_at_truth)) continue;
    ++modelled;
    model += std::pow(c.model_at_truth - truth, 2);
    tracking += std::pow(estimated - c.model_at_truth, 2);
  }
  const auto rms = [](double sum, std::uint64_t count) {
    return count > 0 ? std::sqrt(sum / static_cast<double>(count)) : 0;
  };
  budget.rms = rms(total, budget.count);
  budget.model_rms = rms(model, modelled);
  budget.tracking_rms = rms(tracking, modelled);
  return budget;
}

nlohmann::ordered_json ToJson(const ErrorBudget& budget, const std::string& samples) {
  if (budget.count == 0) return nullptr;
  return {{"rms_N", budget.rms},
          {"peak_N", budget.peak_error},
          {"contact_" + samples, budget.count},
          {"true_peak_N", budget.peak_force},
          {"model_rms_N", budget.model_rms},
          {"tracking_rms_N", budget.tracking_rms}};
}

StateRow RowOf(const ContactEstimate& estimate, Time start,
               const std::optional<Eigen::Vector3d>& true_force) {
  return {SecondsBetween(start, estimate.sensed_at),
          estimate.sample,
          "",
          estimate.p_S_tip,
          estimate.p_S_contact,
          estimate.force,
          estimate.sigma,
          estimate.validity,
          estimate.check,
          true_force,
          estimate.details,
          estimate.moment,
          estimate.moment_sigma};
}

StatesFile::StatesFile(const std::filesystem::path& folder, bool has_truth)
    : file_(folder / "states.csv"), has_truth_(has_truth) {
  std::filesystem::create_directories(folder);
  std::filesystem::remove(folder / "summary.json");  // of an earlier run
  stream_.open(file_);
  stream_ << "t,sequence,finger,tip_x,tip_y,tip_z,contact_x,contact_y,contact_z,fx,fy,fz,sigma,"
          << (has_truth ? "validity,true_fx,true_fy,true_fz,check" : "validity,check");
  for (const std::string_view column : kCheckColumns) stream_ << ',' << column;
  stream_ << ",moment_x,moment_y,moment_z,moment_sigma\n" << std::flush;
  RequireWritten(stream_.good(), file_);
}

void StatesFile::Write(const StateRow& row) {
  stream_ << fmt::format("{:.6f},{},{}", row.t, row.sequence, row.finger) << Numbers(row.p_S_tip)
          << Numbers(row.p_S_contact) << Numbers(row.force.value_or(kUnknownVector)) << ','
          << (row.force ? Number(row.sigma) : "") << ',' << ToString(row.validity);
  if (has_truth_) stream_ << Numbers(row.true_force.value_or(kUnknownVector));
  stream_ << ',' << ToString(row.check);
  for (const auto& value : ValuesOf(row.details)) stream_ << ',' << (value ? Number(*value) : "");
  stream_ << Numbers(row.moment.value_or(kUnknownVector)) << ','
          << (row.moment ? Number(row.moment_sigma) : "") << '\n'
          << std::flush;
  RequireWritten(stream_.good(), file_);
}

void RequireWritten(bool written, const std::filesystem::path& file) {
  if (written) return;
  throw std::system_error(errno, std::generic_category(), file.string() + ": cannot be written");
}

}  // namespace palpate
