// The files that a scene is read from, as they travel with a recording.
#pragma once

#include <filesystem>
#include <map>
#include <optional>
#include <string>
#include <vector>

#include <Eigen/Core>

#include "shared/recording/mcap_bytes.h"
#include "slave/scene/scene.h"

namespace palpate {

struct SceneFiles {
  static constexpr std::uintmax_t kMaxBytes = 16 << 20;  // of all files together [bytes]

  std::string scene;                         // name of the scene among the files
  std::map<std::string, std::string> bytes;  // content by path, relative to the common folder
  std::vector<std::string> left_out;         // paths of those that are too large, or unreadable
};

// The scene file first, then its inputs; for folders the files in them.
SceneFiles GatherSceneFiles(const Scene& scene);

// Writes the files below `folder`; returns the path of the scene. Throws InputError: a path outside
// the folder; std::runtime_error: not writable.
std::filesystem::path UnpackSceneFiles(const SceneFiles& files,
                                       const std::filesystem::path& folder);

// The beginning of a slave's recording: its scene, and how its sensing was created.
struct RecordedBeginning {
  // Throws InputError: not an MCAP file, or none of a slave's.
  explicit RecordedBeginning(const std::filesystem::path& file);

  SceneFiles files;
  McapMap note;

  // Returns the fields of the note; empty: absent.
  [[nodiscard]] std::string Value(const std::string& key) const;
  [[nodiscard]] std::vector<std::string> overrides() const;
};

}  // namespace palpate
