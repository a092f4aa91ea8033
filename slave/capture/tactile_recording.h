// Tactile recordings: CSV files of raw counts, and of where the fingertips were.
#pragma once

#include <cstddef>
#include <filesystem>
#include <map>
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

// Columns: a time in seconds (the first of `rel_time_s`, `time_s`, `t_s`, `t`, `timestamp`), per
// finger `NAME_E1` to `NAME_E19`, `NAME_pac0`, `NAME_pdc`, or without `NAME_` for a single finger;
// `ele1` and `pac1` are accepted too. Other sensors: `NAME_c1` to `NAME_cN`; a unit in brackets
// behind the name must be that of `channels`. One header row; lines that begin with # are comments.
// `wanted`: the fingers to read, empty: all. Throws std::runtime_error `file:line: ...`:
// unreadable, a finger or a channel missing or beyond the last (which), a row with more or fewer
// columns than the header, not a finite number, a time that does not increase.
TactileRecording ReadTactileRecording(const std::filesystem::path& file,
                                      std::span<const std::string> wanted,
                                      const TactileChannels& channels = {});

// The fingers that ReadTactileRecording would read; only the header is read. Throws as it does.
std::vector<RecordedFinger> ReadTactileFingers(const std::filesystem::path& file,
                                               std::span<const std::string> wanted,
                                               const TactileChannels& channels = {});

// The recording of the scene with its fingertip poses. A rate within a tenth of the scene's is
// taken as it is, another one down to a quarter is resampled, linear between samples. The first
// frame behind more than three periods without a sample is marked. A finger's first pose is valid
// from three periods before its time, its last one until three periods after it; beyond, the finger
// has no pose. Frames come at the recorded rate by the Clock of the thread that takes them. Throws
// std::runtime_error like ReadTactileRecording, and if no pose is within the recording's time.
std::unique_ptr<TactileSource> OpenTactileRecording(const Scene& scene);

// Where recorded fingertips were: a CSV file of columns `t,finger,x,y,z,qw,qx,qy,qz`: time on the
// recording's clock [s] (or another of its names), finger as the scene calls it (without the
// column: all fingers), origin of F in S [m], rotation of F in S as a quaternion of length one to 1
// %. Rows of fingers that the scene does not have are passed over.
class FingerPoses {
 public:
  // Throws std::runtime_error `file:line: ...`: unreadable, a column missing, not a finite number,
  // not a unit quaternion, a finger's time that does not increase, no pose of any of `fingers`.
  // `hold`: validity of the first pose before its time and of the last one after it [s].
  FingerPoses(const std::filesystem::path& file, const std::vector<Finger>& fingers, double hold);

  // X_SF of `finger` at `t` [s]: between two poses linear in position and spherically linear in
  // rotation. nullopt: no pose for this time.
  [[nodiscard]] std::optional<Eigen::Isometry3d> At(std::string_view finger, double t) const;
  // Throws std::runtime_error naming both: no pose of any finger counts from `begin` to `end` [s].
  void RequireWithin(double begin, double end) const;

 private:
  struct Pose {
    double t = 0;
    Eigen::Isometry3d X_SF = Eigen::Isometry3d::Identity();
  };
  std::filesystem::path file_;
  double hold_;
  std::map<std::string, std::vector<Pose>, std::less<>> poses_;  // by finger, times rising
};

// Which column of a recording is its clock: `rel_time_s`, `time_s`, `t`, `time` or `timestamp`, the
// first that is there. Throws std::runtime_error `file:line: ...`: none is.
std::size_t FindTimeColumn(const CsvTable& rows);

// The time of this row [s]. Throws: no time in seconds, or not later than `*before` (null: the
// first row).
double ReadTime(const CsvTable& rows, std::size_t column, const double* before);

// `share` of the way from one reading to another, 0 to 1; a pose where both have one.
FingerReading Between(const FingerReading& from, const FingerReading& to, double share) noexcept;
// Linear in place, spherically linear in rotation.
Eigen::Isometry3d Between(const Eigen::Isometry3d& from, const Eigen::Isometry3d& to,
                          double share) noexcept;

}  // namespace palpate
