#include "slave/tactile/recordings/recorded_finger.h"

#include <stdexcept>
#include <vector>

namespace palpate {

TactileRecording ReadRecordedFinger(const DataArgument& data, const std::string& finger) {
  const std::vector<std::string> wanted(finger.empty() ? 0 : 1, finger);
  TactileRecording recording = ReadTactileRecording(data.tactile, wanted);
  if (recording.fingers.size() == 1) return recording;
  std::string names;
  for (const RecordedFinger& f : recording.fingers) names += (names.empty() ? "" : ", ") + f.name;
  throw std::runtime_error(data.tactile.string() +
                           ": several fingers: choose one with --finger: " + names);
}

}  // namespace palpate
