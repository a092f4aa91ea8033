// A validated scene: object, sensing, model and operator. SI units, frames as named. `LoadScene` is
// the only function that creates one. Its result is consistent, so no code checks it again.
#pragma once

#include <filesystem>
#include <optional>
#include <string>
#include <vector>

#include "slave/scene/options/model.h"
#include "slave/scene/options/object.h"
#include "slave/scene/options/operation.h"
#include "slave/scene/options/sensing.h"

namespace palpate {

struct Scene {
  std::string name;
  std::filesystem::path file;
  Object object;
  std::optional<Tool> tool;
  SenseOptions sense;
  ModelOptions model;
  OperatorOptions operator_options;
  ManipulatorOptions manipulator;
  LinkOptions link;
  SiteOptions site;
  // Contact points of `study`, O [m]; empty: where the tool would first touch the object.
  std::vector<Eigen::Vector3d> study_contacts;
  // Sensors and manipulator are those of palpate-simulator, see StreamSimulated: nothing real
  // moves.
  bool is_simulated = false;
  std::vector<std::string> overrides;  // applied to `file`, as `key.path=value`
};

// Returns whether the samples of the scene's sensing are simulated.
[[nodiscard]] bool IsSimulated(const Scene& scene);

// Samples of the scene's simulated sensors, and the simulated manipulator, come from
// palpate-simulator: their sources become streams. A scene without simulated sensors is unchanged.
void StreamSimulated(Scene* scene);

// Returns whether the poses of the scene's fingertips are known, so that contacts with the object
// can be computed. Otherwise the object is not deformed and no model is built.
bool MeetsObject(const Scene& scene);

// All inputs of the scene, the scene file first: files, and folders of images and networks.
std::vector<std::filesystem::path> InputFilesOf(const Scene& scene);

}  // namespace palpate
