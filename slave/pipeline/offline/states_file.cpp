#include "slave/pipeline/offline/states_file.h"

#include <cmath>
#include <limits>
#include <stdexcept>

#include <spdlog/fmt/fmt.h>

namespace palpate {
namespace {

std::string Number(double x) {
  return std::isfinite(x) ? fmt::format("{:.9g}", x) : "";
}

// With a comma before each.
std::string Numbers(const Eigen::Vector3d& v) {
  return fmt::format(",{},{},{}", Number(v.x()), Number(v.y()), Number(v.z()));
}

const Eigen::Vector3d kUnknown =
    Eigen::Vector3d::Constant(std::numeric_limits<double>::quiet_NaN());

}  // namespace

StateRow RowOf(const ContactEstimate& felt, Time start,
               const std::optional<Eigen::Vector3d>& true_force) {
  return {SecondsBetween(start, felt.sensed_at),
          felt.sample,
          "",
          felt.p_S_tip,
          felt.p_S_contact,
          felt.force,
          felt.sigma,
          felt.validity,
          true_force};
}

StatesFile::StatesFile(const std::filesystem::path& folder, bool has_truth)
    : file_(folder / "states.csv"), has_truth_(has_truth) {
  std::filesystem::create_directories(folder);
  std::filesystem::remove(folder / "summary.json");  // of an earlier run
  stream_.open(file_);
  stream_ << "t,sequence,finger,tip_x,tip_y,tip_z,contact_x,contact_y,contact_z,fx,fy,fz,sigma,"
          << (has_truth ? "validity,true_fx,true_fy,true_fz\n" : "validity\n") << std::flush;
  RequireWritten(stream_.good(), file_);
}

void StatesFile::Write(const StateRow& row) {
  stream_ << fmt::format("{:.6f},{},{}", row.t, row.sequence, row.finger) << Numbers(row.p_S_tip)
          << Numbers(row.p_S_contact) << Numbers(row.force.value_or(kUnknown)) << ','
          << (row.force ? Number(row.sigma) : "") << ',' << ToString(row.validity);
  if (has_truth_) stream_ << Numbers(row.true_force.value_or(kUnknown));
  stream_ << '\n' << std::flush;
  RequireWritten(stream_.good(), file_);
}

void RequireWritten(bool written, const std::filesystem::path& file) {
  if (!written) throw std::runtime_error(file.string() + ": cannot be written");
}

}  // namespace palpate
