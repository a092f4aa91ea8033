// One finger of a recording.
#pragma once

#include <string>

#include "slave/capture/tactile_recording.h"
#include "slave/tactile/recordings/data_argument.h"

namespace palpate {

// `finger`: its name; empty: the recording's only one. Throws std::runtime_error: as
// ReadTactileRecording, and where there are several fingers to choose from.
TactileRecording ReadRecordedFinger(const DataArgument& data, const std::string& finger);

}  // namespace palpate
