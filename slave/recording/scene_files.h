// The files that a scene is read from, as they travel with a recording.
#pragma once

#include <filesystem>
#include <map>
#include <string>
#include <vector>

#include "slave/scene/scene.h"

namespace palpate {

struct SceneFiles {
  static constexpr std::uintmax_t kMost = 16 << 20;  // of all files together [bytes]

  std::string scene;                         // which of them is the scene
  std::map<std::string, std::string> bytes;  // by path below the folder that they all are in
  std::vector<std::string> left_out;         // paths of those that are too large, or unreadable
};

// The scene file first, then its inputs; for folders the files in them.
SceneFiles GatherSceneFiles(const Scene& scene);

// Writes the files below `folder`; returns the path of the scene. Throws InputError: a path outside
// the folder; std::runtime_error: not writable.
std::filesystem::path UnpackSceneFiles(const SceneFiles& files,
                                       const std::filesystem::path& folder);

}  // namespace palpate
