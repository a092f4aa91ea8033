// Recordings of a fingertip with measured forces or contact normals, as named on the command line.
#pragma once

#include <filesystem>
#include <limits>
#include <optional>
#include <string>
#include <vector>

#include <Eigen/Core>

#include "slave/capture/tactile_recording.h"
#include "slave/tactile/recordings/labelled_recording.h"
#include "slave/tactile/signals/rest_values.h"

namespace palpate {

// TACTILE.csv[+WRENCH.csv][@FROM:TO]
struct DataArgument {
  std::string text;  // unchanged text
  std::filesystem::path tactile;
  std::filesystem::path wrench;  // empty: the tactile file contains the force
  double from = -std::numeric_limits<double>::infinity();  // [s], of the tactile file's clock
  double to = std::numeric_limits<double>::infinity();
};

// FROM or TO may be omitted. A file whose own name contains + or @ is found as well. Throws
// std::invalid_argument: an invalid slice, an empty name.
DataArgument ParseDataArgument(const std::string& text);

// One finger of a recording. `finger`: its name; empty: the recording's only one. Throws
// std::runtime_error: as ReadTactileRecording, and where there are several fingers to choose from.
TactileRecording ReadRecordedFinger(const DataArgument& data, const std::string& finger);

struct RecordedForceOptions {
  std::string finger;     // empty: the only one of the recording
  int rest_samples = 50;  // the first ones of the recording, whose mean is the rest value; >= 1
};

// One recording, or more if it has gaps or the force is unknown for a while. Force columns fx, fy,
// fz or fx_N, fy_N, fz_N [N], of the fingertip on the object, in the tactile file or in the wrench
// file, which is interpolated to the tactile times. The mean of the force's first half second is
// subtracted as its offset. Baseline and offset are those of the whole files, independent of the
// slice. Samples at another rate than the networks' are resampled; the slowest rate is a quarter of
// it. Throws std::runtime_error naming file (and line) and the error.
std::vector<LabelledRecording> ReadRecordedForces(const DataArgument& data,
                                                  const RecordedForceOptions& options);

// True where both contain the same instants of the same file.
bool Overlap(const LabelledRecording& a, const LabelledRecording& b);

}  // namespace palpate
