#include "slave/commands/running_scene.h"

#include <cstdlib>

#include <gtest/gtest.h>

#include "shared/text/text.h"
#include "slave/commands/study/study_command.h"
#include "slave/scene/decided_model.h"
#include "tests/support/scratch.h"

namespace palpate {
namespace {

namespace fs = std::filesystem;

constexpr const char* kAutoBlock = R"(name: block
object:
  geometry: {rectangle: {width: 88 mm, height: 88 mm, thickness: 9 mm}}
  material: {young_modulus: 127 kPa, poisson_ratio: 0.49}
  fixed: {side: bottom}
tool: {shape: flat, width: 5.87 mm, depth: whole}
model: {kind: auto, tolerance: 10 %}
)";

class RunningSceneTest : public FolderTest {
 protected:
  RunningSceneTest() {
    setenv("XDG_CACHE_HOME", (folder_ / "cache").c_str(), 1);
    WriteWholeFile(file_, kAutoBlock);
  }

  Scene Load(const std::vector<std::string>& overrides = {}) const {
    return LoadRunningScene(file_, overrides, SceneUse::kSolve);
  }
  [[nodiscard]] std::vector<fs::path> Kept() const {
    std::vector<fs::path> files;
    for (const auto& entry : fs::directory_iterator(CacheFolder())) files.push_back(entry.path());
    return files;
  }

  const fs::path file_ = folder_ / "scene.yaml";
};

TEST_F(RunningSceneTest, AutoIsDecidedOnceAndKept) {
  const Scene first = Load();
  EXPECT_EQ(first.model.kind, "bem2d");
  EXPECT_FALSE(first.model.decision.reason.empty());
  ASSERT_EQ(Kept().size(), 1U);
  // A stored decision is used: if it is replaced by another one, that one is used.
  Scene other = first;
  other.model.elements = 77;
  WriteWholeFile(Kept().front(), DecidedText(other));
  EXPECT_EQ(Load().model.elements, 77);
  WriteWholeFile(Kept().front(), "torn");
  EXPECT_EQ(DecidedText(Load()).substr(0, 20), DecidedText(first).substr(0, 20));
}

TEST_F(RunningSceneTest, StoredFilesFollowNoLink) {
  Load();
  const fs::path kept = Kept().front(), target = folder_ / "target";
  WriteWholeFile(target, "mine");
  fs::remove(kept);
  fs::create_symlink(target, kept);
  fs::create_symlink(target, kept.string() + ".part");
  Load();
  EXPECT_TRUE(fs::is_regular_file(fs::symlink_status(kept)));
  EXPECT_EQ(ReadWholeFile(target, 100, "text"), "mine");
}

TEST_F(RunningSceneTest, AnotherSceneIsDecidedAgain) {
  Load();
  Load({"object.material.young_modulus=1 kPa"});
  WriteWholeFile(file_, std::string(kAutoBlock) + "# touched\n");
  Load();
  EXPECT_EQ(Kept().size(), 3U);
}

// The decision of a complete study replaces the quick one.
TEST_F(RunningSceneTest, TheResultOfAStudyIsUsedAfterwards) {
  StudyOptions options{.scene = file_, .overrides = {}, .out = folder_ / "study", .budget = 1};
  ASSERT_EQ(RunStudyCommand(options, {}), 0);
  ASSERT_EQ(Kept().size(), 1U);
  const Scene scene = Load();
  EXPECT_EQ(ReadWholeFile(Kept().front(), 1 << 20, "a decision"), DecidedText(scene));
}

}  // namespace
}  // namespace palpate
