// Recordings of a fingertip with measured force.
#pragma once

#include <string>
#include <vector>

#include "slave/tactile/recordings/data_argument.h"
#include "slave/tactile/recordings/labelled_recording.h"

namespace palpate {

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

}  // namespace palpate
