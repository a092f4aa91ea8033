#include "slave/recording/recorded_beginning.h"

#include <array>
#include <sstream>

#include "shared/recording/recording_reader.h"
#include "shared/text/text.h"
#include "slave/recording/sense_recording.h"

namespace palpate {

RecordedBeginning::RecordedBeginning(const std::filesystem::path& file) {
  RecordingReader reader(file);
  reader.Next();
  const auto& notes = reader.mcap().notes();
  const auto found = notes.find(kSenseNote);
  if (found == notes.end()) {
    throw InputError(file.string() +
                     ": contains no sensing: accepted is a recording by a slave (serve --record)");
  }
  note = found->second;
  files.scene = Value("scene");
  for (const McapAttachment& attachment : reader.mcap().attachments()) {
    files.bytes[attachment.name] = attachment.data;
  }
}

std::string RecordedBeginning::Value(const std::string& key) const {
  const auto found = note.find(key);
  return found == note.end() ? std::string() : found->second;
}

std::vector<std::string> RecordedBeginning::overrides() const {
  std::istringstream stream(Value("overrides"));
  std::vector<std::string> lines;
  for (std::string line; std::getline(stream, line);) lines.push_back(line);
  return lines;
}

std::optional<Eigen::Vector3d> RecordedBeginning::tip() const {
  std::istringstream stream(Value("tip"));
  std::array<std::string, 3> words;
  stream >> words[0] >> words[1] >> words[2];
  const auto x = ParseFinite(words[0]), y = ParseFinite(words[1]), z = ParseFinite(words[2]);
  if (!x || !y || !z) return std::nullopt;
  return Eigen::Vector3d(*x, *y, *z);
}

}  // namespace palpate
