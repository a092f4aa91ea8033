// RecordFit estimates delay, drift and hysteresis from a record of two columns of forces.
#pragma once

#include <optional>
#include <vector>

#include <Eigen/Core>

#include "slave/verify/vector_map.h"

namespace palpate {

// Column i: row i of the record, in order of time. Axes that are not compared are 0.
struct ForceRecord {
  Eigen::VectorXd t;           // [s]; empty: unknown
  Eigen::Matrix3Xd measured;   // [N]
  Eigen::Matrix3Xd estimated;  // [N]
};

// Smallest number of rows of a record for these fits.
inline constexpr Eigen::Index kMinFitRows = 50;

// Returns the delay of the estimated force after the measured one [s]; negative: before it. It is
// the delay with the smallest error of a linear map. nullopt: fewer than 50 rows, no time, or the
// forces do not determine it. Delays up to 1 s and a quarter of the record.
std::optional<Interval> EstimateDelay(const ForceRecord& record);

// Replaces the measured force by its value `delay` seconds earlier, linear between rows. Returns
// the rows in which it is known.
std::vector<Eigen::Index> MoveMeasured(double delay, ForceRecord* record);

// Magnitude of the change that a map does not explain [N]; nullopt: the record does not determine
// it.
struct RecordChange {
  std::optional<Interval> drift;  // change of the estimate during the whole record
  Eigen::Vector3d drift_vector{0, 0, 0};
  std::optional<Interval> hysteresis;  // from loading to unloading
};
RecordChange FitChange(const ForceRecord& record);

}  // namespace palpate
