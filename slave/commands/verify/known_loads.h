// Known loads and reported states, read from tables and matched by time.
#pragma once

#include <cmath>
#include <filesystem>
#include <limits>
#include <map>
#include <string>
#include <vector>

#include <Eigen/Core>

namespace palpate {

inline constexpr double kUnknown = std::numeric_limits<double>::quiet_NaN();
inline const Eigen::Vector3d kUnknownVector3 = Eigen::Vector3d::Constant(kUnknown);

// One state of the slave. Frame S; NaN: unknown.
struct ReportedState {
  double t = 0;        // since the first state [s]
  std::string finger;  // empty: the only tool
  Eigen::Vector3d p_S_tip = kUnknownVector3;
  Eigen::Vector3d force = kUnknownVector3;  // of the object on the tool [N]
  double depth = kUnknown;                  // of the tip below the surface at rest [m]
  double sigma = 0;                         // [N]
  bool is_valid = false;
  std::string validity;                        // its name in CSV files
  Eigen::Vector3d measured = kUnknownVector3;  // by a force sensor, or a simulator's truth [N]
};

// What acted on the tool during a time. Frame S; NaN: unknown.
struct KnownLoad {
  double from = 0, until = 0;  // on the clock of the states [s]
  std::string finger;
  Eigen::Vector3d force = kUnknownVector3;  // of the object on the tool [N]
  double sigma = kUnknown;                  // standard deviation of an axis of it [N]
  Eigen::Vector3d p_S_tip = kUnknownVector3;
  double depth = kUnknown;

  // Without `sigma` a reference counts as known to 1 %: weights, springs and gauges rarely are
  // better, and neither is the time of a changing force.
  [[nodiscard]] double sigma_or_usual() const {
    const double size = force.unaryExpr([](double x) { return std::isfinite(x) ? x : 0; }).norm();
    return std::isfinite(sigma) ? sigma : 0.01 * size;
  }
};

struct LoadTable {
  std::vector<KnownLoad> loads;
  bool is_record = false;  // rows are instants of a record, without `until`
};

// A state and the load at its time. `load`: number of the load, or of the stretch of a record.
struct MatchedState {
  ReportedState state;
  KnownLoad known;
  int load = 0;
};
// By finger, in order of time.
using MatchedStates = std::map<std::string, std::vector<MatchedState>>;

// states.csv of `process`. Throws InputError.
std::vector<ReportedState> ReadStates(const std::filesystem::path& file);
void WriteStates(const std::vector<ReportedState>& states, const std::filesystem::path& file);

// Columns t, until, finger, fx, fy, fz, sigma, x, y, z, depth. All but t are optional. An empty
// cell, or a column that is absent, is unknown; but a table without `until` is a record, which is
// linear between rows that are at most 1 s apart. Throws InputError.
LoadTable ReadLoads(const std::filesystem::path& file);
void WriteLoads(const std::vector<KnownLoad>& loads, const std::filesystem::path& file);

// Loads without a finger are those of the tool, which is the first finger. Throws
// std::invalid_argument: no state lies within the time of a load.
MatchedStates Match(const std::vector<ReportedState>& states, const LoadTable& table);
// With what the force sensor measured. Throws std::invalid_argument: it measured nothing.
MatchedStates MatchSensor(const std::vector<ReportedState>& states);

}  // namespace palpate
