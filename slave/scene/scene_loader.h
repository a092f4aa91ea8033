// A YAML file -> one typed, validated Scene.
#pragma once

#include <filesystem>
#include <stdexcept>
#include <string>
#include <vector>

#include <Eigen/Geometry>

#include "slave/scene/scene.h"

namespace palpate {

// One or more mistakes in a scene, one per line: `file:line: key = value: expected ...`.
class SceneError : public std::runtime_error {
 public:
  using std::runtime_error::runtime_error;
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

// As scenes are written: `pose: {translation: [...], rotation: [...]}`, rotation about fixed x, y,
// z.
std::string ScenePose(const Eigen::Isometry3d& X);

}  // namespace palpate
