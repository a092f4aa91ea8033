// The beginning of a slave's recording: its scene, and how its sensing was created.
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

  // Fields of the note; empty: absent.
  [[nodiscard]] std::string Value(const std::string& key) const;
  [[nodiscard]] std::vector<std::string> overrides() const;
  // Tool position of the simulated environment, S [m]; nullopt: a real environment.
  [[nodiscard]] std::optional<Eigen::Vector3d> tip() const;
};

}  // namespace palpate
