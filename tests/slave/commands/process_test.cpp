#include "slave/commands/process/process.h"

#include <fstream>
#include <limits>
#include <stdexcept>
#include <string>

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include "tests/support/paths.h"
#include "tests/support/scratch.h"
#include "tests/support/thrown.h"

namespace palpate {
namespace {

using ::testing::HasSubstr;

const std::filesystem::path kProcessedScenes = SourcePath("/deploy/scenes");

std::string Refusal(const char* scene, double duration) {
  const Scratch scratch;
  ProcessOptions options;
  options.scene = kProcessedScenes / scene;
  options.out = scratch / "refused";
  options.duration = duration;
  return Thrown<std::invalid_argument>([&] { RunProcess(options, {}); });
}

TEST(ProcessTest, OnlyAMovingTargetHasADuration) {
  for (const char* scene : {"silicone-block.yaml", "rubber-membrane.yaml"}) {
    EXPECT_THAT(Refusal(scene, 5), HasSubstr("--duration: only for a simulated target")) << scene;
  }
}

// Returns the error message for a scene in `out` with one additional line.
std::string RefusalInside(const std::filesystem::path& out, const std::string& name, bool frames) {
  ProcessOptions options;
  options.scene = out / name;
  options.out = out;
  options.frames = frames;
  return Thrown<std::invalid_argument>([&] { RunProcess(options, {}); });
}

TEST(ProcessTest, WritesOverNothingItReads) {
  const Scratch scratch;
  const auto& folder = scratch.path();
  std::filesystem::create_directories(folder / "frames");
  std::filesystem::copy(kProcessedScenes / "silicone-block.yaml", folder / "summary.json");
  EXPECT_THAT(RefusalInside(folder, "summary.json", false),
              HasSubstr("summary.json: expected another file"));
  std::ofstream(folder / "frames" / "1.png") << "not looked at";
  std::ofstream(folder / "recorded.yaml") << R"(name: recorded
object:
  geometry: {rectangle: {width: 80 mm, height: 40 mm, thickness: 9 mm}}
  material: {young_modulus: 127 kPa, poisson_ratio: 0.49}
  fixed: {side: bottom}
model: {kind: bem2d}
tool: {shape: flat, width: 5.87 mm, depth: whole}
sense:
  camera: {file: "frames/%d.png", pixel: 0.35 mm}
  tip: {track: template}
  contour: {track: snake}
)";
  EXPECT_THAT(RefusalInside(folder, "recorded.yaml", true),
              HasSubstr("--frames " + (folder / "frames").string()));
}

}  // namespace
}  // namespace palpate
