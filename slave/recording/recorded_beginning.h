// What stands before the messages of a slave's recording: its scene, and how its sense was made.
#pragma once

#include <filesystem>
#include <optional>
#include <string>
#include <vector>

#include <Eigen/Core>

#include "shared/recording/mcap_bytes.h"
#include "slave/recording/scene_files.h"

namespace palpate {

struct RecordedBeginning {
  // Throws InputError: not an MCAP file, or none of a slave's.
  explicit RecordedBeginning(const std::filesystem::path& file);

  SceneFiles files;
  McapMap note;

  // Of the note; empty: it does not tell.
  [[nodiscard]] std::string Value(const std::string& key) const;
  [[nodiscard]] std::vector<std::string> overrides() const;
  // Where the tool of the simulated site was, S [m]; nullopt: it was a real one.
  [[nodiscard]] std::optional<Eigen::Vector3d> tip() const;
};

}  // namespace palpate
