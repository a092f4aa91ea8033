#include "tests/slave/scene/stereo_scene.h"

#include "tests/support/thrown.h"

namespace palpate {
namespace {

// Returns a stereo rig's file with those entries that a scene reads.
std::string RigText(const std::string& cameras) {
  std::string text = "%YAML:1.0\n---\n";
  for (const char camera : cameras) {
    text += std::string(camera == 'l' ? "left" : "right") +
            ":\n   image_width: 640\n   image_height: 480\n"
            "   camera_matrix: !!opencv-matrix\n      rows: 3\n      cols: 3\n      dt: d\n"
            "      data: [ 800., 0., 319.5, 0., 800., 239.5, 0., 0., 1. ]\n";
  }
  return text + "rms_px: 0.2\n";
}

}  // namespace

std::string StereoScene(const SceneLines& lines) {
  return "name: pair\n"  // 1
         "object:\n"     // 2
         "  geometry: " +
         lines.geometry +                                                             // 3
         "\n  material: {young_modulus: 27.2 MPa, poisson_ratio: 0.45}\n" +           // 4
         (lines.fixed.empty() ? "  pose: {}\n" : "  fixed: " + lines.fixed + "\n") +  // 5
         "model: " + lines.model +                                                    // 6
         "\ntool: " + lines.tool +                                                    // 7
         "\n"
         "sense:\n"  // 8
         "  camera: " +
         lines.camera +                          // 9
         "\n  points: " + lines.points + "\n" +  // 10
         lines.more;                             // 11
}

StereoSceneTest::StereoSceneTest() {
  std::filesystem::create_directory(folder_.path() / "pairs");
  std::filesystem::create_directory(folder_.path() / "empty");
  for (const char* name : {"left_00.png", "left_01.png", "right_00.png", "right_01.png"}) {
    folder_.Write(std::string("pairs/") + name, "");
  }
  folder_.Write("rig.yaml", RigText("lr"));
  folder_.Write("left.yaml", RigText("l"));
  folder_.Write("right.yaml", RigText("r"));
  folder_.Write("broken.yaml", "left: [\n");
  folder_.Write("dots.csv", "x,y\n0,0\n0.01,0\n0,0.01\n-0.012,0\n");
  folder_.Write("close.csv", "0,0\n0.01,0\n0,0.001\n");
  folder_.Write("wide.csv", "0,0\n0.01,0\n0,0.0385\n");
  folder_.Write("words.csv", "0,0\n0.01,zero\n");
}

std::string StereoSceneTest::MistakesOf(const SceneLines& lines, SceneUse use) const {
  return Thrown<SceneError>([&] { Load(lines, use); });
}

}  // namespace palpate
