// What a record of known and reported forces shows besides their map: delay, drift, hysteresis, and
// how many neighbouring rows share their errors.
#pragma once

#include <optional>
#include <vector>

#include <Eigen/Core>

#include "slave/commands/verify/map_fit.h"
#include "slave/statistics/intervals.h"

namespace palpate {

// Column i: row i of the record, in order of time. Axes that are not compared are 0.
struct ForceRecord {
  Eigen::VectorXd t;          // [s]; empty: unknown
  Eigen::Matrix3Xd known;     // [N]
  Eigen::Matrix3Xd reported;  // [N]
};

// Directions that the known forces of a record test: orthonormal columns, the largest first.
Eigen::MatrixXd TestedDirections(const Eigen::Matrix3Xd& known);

// How long the reported force comes after the known one [s]; negative: before it. The delay with
// the least error of a linear map, and its interval from the curvature there. nullopt: fewer than
// 50 rows, no time, or the forces do not tell it. Delays up to 1 s and a quarter of the record.
std::optional<Interval> EstimateDelay(const ForceRecord& record);

// The known forces of `record`, linear between rows, `delay` seconds earlier. Rows whose force is
// not known then are dropped, from `kept` as well, which numbers the rows.
void MoveKnown(double delay, ForceRecord* record, std::vector<std::size_t>* kept);

// The map between forces about their means. `back`: from reported to known forces. Errors of the
// reported force make gains of the first too small where that force is a prediction that tends to
// its mean, and gains of the second too small otherwise: the truth lies between the first and one
// over the second. Source: Frisch (1934), bounds of errors in variables.
struct RecordMap {
  MapFit forth, back;
  double repeats = 1;  // neighbouring rows that share their errors
};
RecordMap FitRecord(const ForceRecord& record, const std::vector<int>& axes);

// Size of what a map does not explain [N]; nullopt: there is no time.
struct RecordChange {
  std::optional<Interval> drift;  // change during the whole record
  Eigen::Vector3d drift_vector{0, 0, 0};
  std::optional<Interval> hysteresis;  // from loading to unloading
};
RecordChange FitChange(const ForceRecord& record);

}  // namespace palpate
