// Scenes of two cameras and of depth images, one thing per line, with the files that they name.
#pragma once

#include <string>

#include <gtest/gtest.h>

#include "slave/scene/scene_loader.h"
#include "tests/slave/scene/scene_file.h"
#include "tests/support/scratch.h"

namespace palpate {

inline constexpr const char* kMembrane = "{membrane: {radius: 39 mm, thickness: 1 mm}}";
inline constexpr const char* kBox = "{box: {size: [60 mm, 40 mm, 20 mm], cells: [3, 2, 1]}}";
inline constexpr const char* kPair = "{source: simulated, pair: {}}";
inline constexpr const char* kFiles =
    "{stereo: {left: \"pairs/left_%02d.png\", right: \"pairs/right*.png\", rig: rig.yaml}, "
    "rate: 20 Hz, pose: {translation: [1 mm, 2 mm, -250 mm], rotation: [0, 0, 90 deg]}}";

struct SceneLines {
  std::string camera = kPair;
  std::string points = "{}";
  std::string geometry = kMembrane;
  std::string fixed = "{side: rim}";
  std::string model = "{kind: plate-large}";
  std::string more{};
  std::string tool = "{shape: flat, width: 4 mm}";
};

// Line 2 is `object`, 3 its geometry, 5 the supports, 6 the model, 7 the tool, 9 the camera, 10 the
// points, from 11 on `more`.
std::string StereoScene(const SceneLines& lines);

// A fixture with the files that these scenes use.
class StereoSceneTest : public ::testing::Test {
 protected:
  StereoSceneTest();
  Scene Load(const SceneLines& lines, SceneUse use = SceneUse::kFull) const {
    return LoadScene(folder_.Write("scene.yaml", StereoScene(lines)), {}, use);
  }
  // Returns the error message of loading; empty: no error.
  std::string MistakesOf(const SceneLines& lines, SceneUse use = SceneUse::kFull) const;
  Scratch folder_;
};

}  // namespace palpate
