// Recordings of a fingertip with measured forces or contact normals, as the command line names
// them.
#pragma once

#include <filesystem>
#include <limits>
#include <optional>
#include <string>
#include <vector>

#include <Eigen/Core>

#include "slave/capture/tactile_recording.h"
#include "slave/tactile/recordings/labelled_recording.h"
#include "slave/tactile/rest_values.h"

namespace palpate {

// TACTILE.csv[+WRENCH.csv][@FROM:TO]
struct DataArgument {
  std::string text;  // as it was given
  std::filesystem::path tactile;
  std::filesystem::path wrench;  // empty: the force stands in the tactile file
  double from = -std::numeric_limits<double>::infinity();  // [s], of the tactile file's clock
  double to = std::numeric_limits<double>::infinity();
};

// FROM or TO may be left out. A file whose own name contains + or @ is found as it is. Throws
// std::invalid_argument: a slice that is none, an empty name.
DataArgument ParseDataArgument(const std::string& text);

// One finger of a recording. `finger`: its name; empty: the recording's only one. Throws
// std::runtime_error: as ReadTactileRecording, and where there are several fingers to choose from.
TactileRecording ReadRecordedFinger(const DataArgument& data, const std::string& finger);

struct RecordedForceOptions {
  std::string finger;     // empty: the only one of the recording
  int rest_samples = 50;  // the first ones of the recording, whose mean is the rest value; >= 1
};

// One recording, or more where it has gaps or the force is not known for a while. Force columns
// fx, fy, fz or fx_N, fy_N, fz_N [N], of the fingertip on the object, in the tactile file or in the
// wrench file, which is interpolated to the tactile times; the mean of the force's first half
// second is its offset and taken off. Rest values and offset are those of the whole files, whatever
// slice is wanted. Samples at another rate than that of the networks are resampled, a quarter of it
// is the slowest. Throws std::runtime_error naming file (and line) and what is wrong with it.
std::vector<LabelledRecording> ReadRecordedForces(const DataArgument& data,
                                                  const RecordedForceOptions& options);

// True where both contain the same instants of the same file.
bool Overlap(const LabelledRecording& a, const LabelledRecording& b);

// The samples in contact, in their order.
struct ContactNormals {
  std::vector<TactileSignals> change;    // counts minus rest
  std::vector<Eigen::Vector3d> normals;  // unit, as in the file
  double contact_pdc = 0;                // contact is above it [counts]
};

// Columns nx, ny, nz beside a finger's electrodes and pdc. Contact: pdc above `contact_pdc`; where
// that is not given, above its level at rest (the second percentile) by a twentieth of its range.
// Rest values: medians of all rows without contact, the slice's or not. Throws std::runtime_error
// naming file (and line) and what is wrong with it.
ContactNormals ReadContactNormals(const DataArgument& data, const std::string& finger,
                                  std::optional<double> contact_pdc);

}  // namespace palpate
