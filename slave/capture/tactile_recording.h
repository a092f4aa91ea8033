// Tactile recordings: CSV files of raw counts, with the poses of the fingertips or without.
#pragma once

#include <cstddef>
#include <filesystem>
#include <memory>
#include <optional>
#include <span>
#include <string>
#include <string_view>
#include <vector>

#include <Eigen/Geometry>

#include "slave/capture/tactile_frame.h"
#include "slave/scene/scene.h"

namespace palpate {

class CsvTable;

struct RecordedFinger {
  std::string name;  // empty where the file has one finger without a name
  bool has_pac = false, has_pdc = false;
  std::vector<FingerReading> samples;  // one per instant
  // The missing column pac0 or pdc, for example `rf_pdc`; empty: none is missing.
  [[nodiscard]] std::string MissingColumn() const;
};
struct TactileRecording {
  std::vector<double> t;  // [s], rising, as in the file
  std::vector<RecordedFinger> fingers;
};

// Columns: a time in seconds (see FindTimeColumn), per finger `NAME_E1` to `NAME_E19`, `NAME_pac0`,
// `NAME_pdc`, or without `NAME_` for a single finger; `ele1` and `pac1` are accepted too. Other
// sensors: `NAME_c1` to `NAME_cN`; a unit in brackets behind the name must be that of `channels`. A
// finger's pose, if it has one: `NAME_x`, `NAME_y`, `NAME_z` (origin of F in S [m]) and `NAME_qw`
// to `NAME_qz` (rotation of F in S, a quaternion of length one to 1 %). One header row; lines that
// begin with # are comments. `wanted`: the fingers to read, empty: all. Throws std::runtime_error
// `file:line: ...`: unreadable, a finger or a channel missing or beyond the last (which), part of
// the columns of a pose, a row with more or fewer columns than the header, not a finite number, not
// a unit quaternion, a time that does not increase.
TactileRecording ReadTactileRecording(const std::filesystem::path& file,
                                      std::span<const std::string> wanted,
                                      const TactileChannels& channels = {});

// The fingers that ReadTactileRecording would read; only the header is read. Throws the same
// exceptions.
std::vector<RecordedFinger> ReadTactileFingers(const std::filesystem::path& file,
                                               std::span<const std::string> wanted,
                                               const TactileChannels& channels = {});

// The recording of the scene. A rate within a tenth of the scene's is used unchanged; another one,
// down to a quarter, is resampled: linearly, and spherically for rotations. The first frame after
// more than three periods without a sample is marked. Frames come at the recorded rate by the Clock
// of the thread that takes them. Throws std::runtime_error like ReadTactileRecording.
std::unique_ptr<TactileSource> OpenTactileRecording(const Scene& scene);

// Returns the column of a recording that is its clock: the first of `rel_time_s`, `time_s`,
// `t_s`, `t`, `time`, `timestamp` that is there. Throws std::runtime_error `file:line: ...`: none
// is.
std::size_t FindTimeColumn(const CsvTable& rows);

// The time of this row [s]. Throws: no time in seconds, or not later than `*before` (null: the
// first row).
double ReadTime(const CsvTable& rows, std::size_t column, const double* before);

// Interpolates between two readings: `share` 0 gives the first, 1 the second. The result has a pose
// if both have one.
FingerReading Between(const FingerReading& from, const FingerReading& to, double share) noexcept;
// Interpolates the position linearly and the rotation spherically.
Eigen::Isometry3d Between(const Eigen::Isometry3d& from, const Eigen::Isometry3d& to,
                          double share) noexcept;

}  // namespace palpate
