#include "slave/recording/scene_files.h"

#include <algorithm>
#include <array>
#include <sstream>

#include "shared/recording/recording_reader.h"
#include "shared/text/text.h"
#include "slave/recording/sense_recording.h"

namespace palpate {
namespace {

namespace fs = std::filesystem;

// Returns `path`, or the regular files in it if it is a folder.
std::vector<fs::path> FilesOf(const fs::path& path) {
  std::error_code error;
  const fs::path whole = fs::weakly_canonical(path, error);
  if (fs::is_regular_file(whole, error)) return {whole};
  std::vector<fs::path> files;
  for (const auto& entry : fs::directory_iterator(whole, error)) {
    if (entry.is_regular_file(error)) files.push_back(entry.path());
  }
  std::ranges::sort(files);
  return files;
}

// Returns the deepest folder that contains both.
fs::path CommonFolder(const fs::path& a, const fs::path& b) {
  fs::path common;
  for (auto i = a.begin(), j = b.begin(); i != a.end() && j != b.end() && *i == *j; ++i, ++j) {
    common /= *i;
  }
  return common;
}

bool StaysInside(const fs::path& path) {
  return path.is_relative() && !path.empty() &&
         std::ranges::none_of(path, [](const fs::path& part) { return part == ".."; });
}

}  // namespace

SceneFiles GatherSceneFiles(const Scene& scene) {
  SceneFiles gathered;
  std::map<fs::path, std::string> kept;
  std::uintmax_t room = SceneFiles::kMaxBytes;
  for (const fs::path& input : InputFilesOf(scene)) {
    for (const fs::path& file : FilesOf(input)) {
      try {
        const std::string bytes = ReadWholeFile(file, room, "a file of the scene");
        if (kept.emplace(file, bytes).second) room -= bytes.size();
      } catch (const InputError&) {
        gathered.left_out.push_back(file.string());
      }
    }
  }
  const auto scene_file = FilesOf(scene.file);
  if (scene_file.empty()) return gathered;
  fs::path common = scene_file.front().parent_path();
  for (const auto& [file, bytes] : kept) common = CommonFolder(common, file.parent_path());
  for (auto& [file, bytes] : kept) {
    gathered.bytes[file.lexically_relative(common).string()] = std::move(bytes);
  }
  gathered.scene = scene_file.front().lexically_relative(common).string();
  return gathered;
}

fs::path UnpackSceneFiles(const SceneFiles& files, const fs::path& folder) {
  for (const auto& [name, bytes] : files.bytes) {
    if (!StaysInside(name)) {
      throw InputError("attached file " + Shown(name) + ": expected a path inside its folder");
    }
    const fs::path file = folder / name;
    fs::create_directories(file.parent_path());
    WriteWholeFile(file, bytes);
  }
  if (!files.bytes.contains(files.scene)) {
    throw InputError("no scene is attached: expected a recording by a slave (serve --record)");
  }
  return folder / files.scene;
}

RecordedBeginning::RecordedBeginning(const std::filesystem::path& file) {
  RecordingReader reader(file);
  reader.Next();
  const auto& notes = reader.mcap().notes();
  const auto found = notes.find(kSenseNote);
  if (found == notes.end()) {
    throw InputError((reader.damage().empty() ? file.string() : reader.damage()) +
                     ": contains no sensing: expected a recording by a slave (serve --record)");
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

}  // namespace palpate
