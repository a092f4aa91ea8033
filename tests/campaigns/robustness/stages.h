// Scenes as they are shipped, and the course of a press, for the files of the stages.
#pragma once

#include <cstddef>
#include <memory>
#include <string>
#include <vector>

#include "slave/scene/scene.h"
#include "tests/campaigns/robustness/moment.h"
#include "tests/campaigns/robustness/stage.h"

namespace palpate::robustness {

using Overrides = std::vector<std::string>;
Scene Shipped(const std::string& name, const Overrides& overrides);

// Number of samples of each part of a press.
struct Counts {
  std::size_t rest = 0, in = 0, hold = 0, back = 0, after = 0;

  [[nodiscard]] Script script() const;
  // Returns the fraction of the full indentation at this sample, 0 to 1.
  [[nodiscard]] double WayAt(std::size_t index) const;
};

// One camera; two; depth images of the same membrane; fingertips.
std::unique_ptr<Stage> MakeCameraStage(const std::string& name, Extent extent);
std::unique_ptr<Stage> MakePairStage(const std::string& name, const Overrides& overrides,
                                     Extent extent);
std::unique_ptr<Stage> MakeDepthStage(const std::string& name, Extent extent);
std::unique_ptr<Stage> MakeTouchStage(const std::string& name, const std::string& scene,
                                      const Overrides& overrides, Extent extent);

// Makes the stage of any scene with `counts` samples. For depth images, the scene has a camera
// pair, which the depth images replace.
std::unique_ptr<Stage> MakeCameraStage(Scene scene, const Counts& counts);
std::unique_ptr<Stage> MakePairStage(Scene scene, const Counts& counts);
std::unique_ptr<Stage> MakeDepthStage(Scene scene, const Counts& counts);
std::unique_ptr<Stage> MakeTouchStage(Scene scene, const Counts& counts);

}  // namespace palpate::robustness
