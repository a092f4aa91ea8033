#include "slave/commands/process.h"

#include <limits>
#include <stdexcept>
#include <string>

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include "tests/support/paths.h"

namespace palpate {
namespace {

using ::testing::HasSubstr;

const std::filesystem::path kScenes = SourcePath("/deploy/scenes");

std::string Refusal(const char* scene, double duration) {
  ProcessOptions options;
  options.scene = kScenes / scene;
  options.out = std::filesystem::temp_directory_path() / "process-refused";
  options.duration = duration;
  try {
    RunProcess(options, {});
  } catch (const std::invalid_argument& error) {
    return error.what();
  }
  return "nothing";
}

TEST(ProcessTest, ADurationIsANumberOfSeconds) {
  for (const double duration : {0.0, -1.0, 1e9, std::numeric_limits<double>::quiet_NaN()}) {
    EXPECT_THAT(Refusal("heart-target.yaml", duration), HasSubstr("accepted is 0 < seconds <="));
  }
}

TEST(ProcessTest, OnlyATargetThatGoesOnHasADuration) {
  for (const char* scene : {"silicone-block.yaml", "rubber-membrane.yaml"}) {
    EXPECT_THAT(Refusal(scene, 5), HasSubstr("--duration: accepted for a simulated target"))
        << scene;
  }
}

}  // namespace
}  // namespace palpate
