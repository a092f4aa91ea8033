// A YAML file -> one typed, validated Scene.
#pragma once

#include <filesystem>
#include <memory>
#include <stdexcept>
#include <string>
#include <utility>
#include <vector>

#include <Eigen/Geometry>

#include "slave/scene/scene.h"
#include "slave/scene/scene_mistake.h"

namespace palpate {

// One or more mistakes in a scene, one per line: `file:line: key = value: expected ...`.
class SceneError : public std::runtime_error {
 public:
  SceneError(const std::string& text, std::vector<SceneMistake> mistakes)
      : std::runtime_error(text), mistakes_(std::move(mistakes)) {}
  // In the file's order; at most 50.
  [[nodiscard]] const std::vector<SceneMistake>& mistakes() const noexcept { return mistakes_; }

 private:
  std::vector<SceneMistake> mistakes_;
};

// How much of a scene a command needs: `solve` needs no tool, camera or operator.
enum class SceneUse { kSolve, kFull };

// Reads `file`; `overrides` are `key.path=value` pairs as on the command line, applied to the YAML
// before validation, e.g. `model.elements=60`; a mistake in one is reported as `--override
// model.elements=x: expected`. Throws SceneError naming every mistake: unreadable, not YAML,
// unknown key (with the nearest known one), missing key, unit of the wrong dimension, impossible
// value.
Scene LoadScene(const std::filesystem::path& file, const std::vector<std::string>& overrides = {},
                SceneUse use = SceneUse::kFull);

// Reads a scene from the text of a YAML file, for `solve`. A mesh in memory, if given, replaces the
// file of `object.geometry.mesh`. Relative paths start at the working folder. Throws SceneError as
// LoadScene.
Scene ParseScene(const std::string& text, std::shared_ptr<const GivenMesh> mesh = {});

// Formats a pose as in scenes: `pose: {translation: [...], rotation: [...]}`, rotation about fixed
// x, y, z.
std::string ScenePose(const Eigen::Isometry3d& X);

}  // namespace palpate
