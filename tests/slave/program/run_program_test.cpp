#include "slave/program/run_program.h"

#include <csignal>
#include <stdexcept>
#include <thread>

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include "slave/program/progress.h"
#include "tests/slave/mechanics/mesher/path_guard.h"
#include "tests/support/scratch.h"

namespace palpate {
namespace {

using ::testing::HasSubstr;
using namespace std::chrono_literals;

using RunProgramTest = FolderTest;

TEST_F(RunProgramTest, ReturnsStatusAndOutput) {
  const ProgramEnd end = RunProgram(
      "/bin/sh", {"-c", "pwd; echo \"a 'b' $LC_ALL\" >&2; cat; exit 3"}, folder_ / "", 10s, {});
  EXPECT_EQ(end.status, 3);
  EXPECT_THAT(end.output, HasSubstr((folder_ / "").parent_path().filename().string()));
  EXPECT_THAT(end.output, HasSubstr("a 'b' C\n"));
}

// No shell reads the words.
TEST_F(RunProgramTest, PassesArgumentsAsTheyAre) {
  EXPECT_EQ(RunProgram("/bin/echo", {"$HOME;", "`id`", "a  b"}, folder_ / "", 10s, {}).output,
            "$HOME; `id` a  b\n");
}

TEST_F(RunProgramTest, ReportsTheSignalThatEndedIt) {
  EXPECT_EQ(RunProgram("/bin/sh", {"-c", "kill -ABRT $$"}, folder_ / "", 10s, {}).status,
            128 + SIGABRT);
}

TEST_F(RunProgramTest, KeepsTheLastOfMuchOutput) {
  const ProgramEnd end =
      RunProgram("/bin/sh", {"-c", "i=0; while [ $i -lt 2000 ]; do echo line $i; i=$((i+1)); done"},
                 folder_ / "", 30s, {});
  EXPECT_EQ(end.output.size(), 4000U);
  EXPECT_THAT(end.output, ::testing::EndsWith("line 1999\n"));
}

// Also kills the program's child, which would write to the folder after its removal.
TEST_F(RunProgramTest, KillsWhatTakesTooLong) {
  const auto began = std::chrono::steady_clock::now();
  EXPECT_THROW(
      RunProgram("/bin/sh", {"-c", "sleep 60 & echo $! > child; wait"}, folder_ / "", 500ms, {}),
      std::runtime_error);
  EXPECT_LT(std::chrono::steady_clock::now() - began, 30s);
  const int child = std::stoi(Scratch::Read(folder_ / "child"));
  // It may stay as a zombie until its new parent has taken notice.
  const auto gone = [&] {
    return kill(child, 0) != 0 ||
           Scratch::Read("/proc/" + std::to_string(child) + "/stat").find(") Z") !=
               std::string::npos;
  };
  for (int i = 0; i < 500 && !gone(); ++i) std::this_thread::sleep_for(10ms);
  EXPECT_TRUE(gone());
}

TEST_F(RunProgramTest, StopsWhenAskedTo) {
  std::stop_source source;
  const std::jthread later([&] {
    std::this_thread::sleep_for(100ms);
    source.request_stop();
  });
  EXPECT_THROW(RunProgram("/bin/sleep", {"60"}, folder_ / "", 60s, source.get_token()),
               Interrupted);
}

TEST_F(RunProgramTest, WritesThroughNoLink) {
  std::filesystem::create_symlink(Write("target", "mine"), folder_ / "log");
  EXPECT_THROW(RunProgram("/bin/echo", {"a"}, folder_ / "", 10s, {}), std::runtime_error);
  EXPECT_EQ(Scratch::Read(folder_ / "target"), "mine");
}

TEST_F(RunProgramTest, SaysWhatCannotBeStarted) {
  Write("text", "not a program");
  EXPECT_THROW(RunProgram(folder_ / "text", {}, folder_ / "", 10s, {}), std::runtime_error);
}

TEST(FindProgramTest, FindsExecutablesOnThePathOnly) {
  const Scratch folder;
  const auto file = folder.Write("palpate-probe", "#!/bin/sh\n");
  const PathGuard path("/nowhere::" + (folder / "").string());
  EXPECT_FALSE(FindProgram("palpate-probe"));
  std::filesystem::permissions(file, std::filesystem::perms::owner_all);
  ASSERT_TRUE(FindProgram("palpate-probe"));
  EXPECT_TRUE(std::filesystem::equivalent(*FindProgram("palpate-probe"), file));
}

}  // namespace
}  // namespace palpate
