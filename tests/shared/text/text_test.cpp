#include "shared/text/text.h"

#include <array>
#include <filesystem>
#include <set>
#include <string>

#include <fcntl.h>
#include <gmock/gmock.h>
#include <gtest/gtest.h>
#include <sys/stat.h>
#include <unistd.h>

#include "tests/support/scratch.h"
#include "tests/support/thrown.h"

namespace palpate {
namespace {

namespace fs = std::filesystem;
using testing::HasSubstr;

class TextFileTest : public FolderTest {
 protected:
  [[nodiscard]] std::set<std::string> Names() const {
    std::set<std::string> names;
    for (const auto& entry : fs::directory_iterator(folder_)) names.insert(entry.path().filename());
    return names;
  }

  // What is said of writing to `out` what is read from `input`.
  static std::string Refusal(const fs::path& out, const fs::path& input) {
    const std::array inputs{fs::path(), fs::path("/nowhere"), input};
    return Thrown<std::invalid_argument>([&] { RequireOtherThan("--out", out, inputs); });
  }
};

TEST(ParseFiniteTest, TakesWholeNumbersInTheirPlainForm) {
  EXPECT_EQ(ParseFinite("+3e4"), 3e4);
  EXPECT_EQ(ParseFinite("-0.5"), -0.5);
  for (const char* text : {"", "+", "+-1", "1 ", "0x1", "nan", "inf", "1e999", "1,5"}) {
    EXPECT_FALSE(ParseFinite(text)) << text;
  }
}

TEST(ShownTest, IsShortAndMovesNoCursor) {
  EXPECT_EQ(Shown("a\x1b]0;b\x07\x7f", 6), "a?]0;b...");
  EXPECT_EQ(Trimmed(" \ta b\r\n"), "a b");
}

// Bytes that no message can carry: cut characters, overlong ones, surrogates, beyond Unicode. What
// is short enough ends as it is.
TEST(ShownTest, IsUtf8WhateverItIsGiven) {
  EXPECT_EQ(Shown("\xC3\xA4\xE2\x82\xAC\xF0\x9F\x98\x80", 9),
            "\xC3\xA4\xE2\x82\xAC\xF0\x9F\x98\x80");
  EXPECT_EQ(Shown("\xC3\xA4\xE2\x82\xAC\xF0\x9F\x98\x80", 8), "\xC3\xA4\xE2\x82\xAC...");
  EXPECT_EQ(Shown("a\xE2\x82"), "a??");
  EXPECT_EQ(Shown("\xC0\xAF\xE0\x80\xAF"), "?????");
  EXPECT_EQ(Shown("\xED\xA0\x80\xF4\x90\x80\x80\xFF"), "????????");
}

// C0, DEL, C1 (U+009B begins a terminal's sequence), bidi overrides and isolates, line separators,
// bytes that are no UTF-8. Letters of two, three and four bytes stay and count as one.
TEST(PresentableTest, NothingMovesACursorOrTurnsTheWriting) {
  EXPECT_EQ(Presentable("a\xE2\x80z\xC3\x80\x80", 20), "a  z\xC3\x80 ");
  EXPECT_EQ(Presentable("a\nb\x1b[2Jc\x7f", 20), "a b [2Jc ");
  EXPECT_EQ(Presentable("a\xC2\x9B"
                        "2Jb",
                        20),
            "a 2Jb");
  EXPECT_EQ(Presentable("a\xE2\x80\xAE"
                        "b\xE2\x81\xA6"
                        "c\xE2\x80\xA8",
                        20),
            "a b c ");
  EXPECT_EQ(Presentable("\xFF"
                        "a",
                        20),
            " a");
  const std::string letters = "\xC3\xA9\xE2\x82\xAC\xF0\x9F\x98\x80";
  EXPECT_EQ(Presentable(letters + "x", 3), letters);
}

TEST_F(TextFileTest, WhatIsWrittenIsRead) {
  const std::string bytes("a\0\r\n", 4);
  WriteWholeFile(folder_ / "a", bytes);
  EXPECT_EQ(ReadWholeFile(folder_ / "a", 4, "text"), bytes);
  EXPECT_THROW(WriteWholeFile(folder_ / "no" / "a", bytes), std::runtime_error);
  ReplaceFile(folder_ / "a", "new");
  EXPECT_EQ(ReadWholeFile(folder_ / "a", 4, "text"), "new");
  EXPECT_THROW(ReplaceFile(folder_ / "no" / "a", bytes), std::runtime_error);
  fs::create_directories(folder_ / "taken");
  EXPECT_THROW(ReplaceFile(folder_ / "taken", bytes), std::runtime_error);
  EXPECT_EQ(Names(), (std::set<std::string>{"a", "taken"})) << "no temporary file is left";
  EXPECT_FALSE(TryReplace(folder_ / "a", [](std::FILE*) { return false; }));
  EXPECT_EQ(ReadWholeFile(folder_ / "a", 4, "text"), "new");
  EXPECT_EQ(Names(), (std::set<std::string>{"a", "taken"}));
}

TEST_F(TextFileTest, TemporaryFilesAreNewAndHaveARandomName) {
  std::set<std::string> names;
  for (int i = 0; i < 3; ++i) {
    ASSERT_TRUE(TryReplace(folder_ / "a", [&](std::FILE* file) {
      const auto open = fs::read_symlink("/proc/self/fd/" + std::to_string(fileno(file)));
      EXPECT_EQ(open.parent_path(), fs::canonical(folder_)) << "so that renaming is atomic";
      names.insert(open.filename());
      return true;
    }));
  }
  EXPECT_EQ(names.size(), 3U);
  EXPECT_EQ(Names(), std::set<std::string>{"a"});
}

TEST_F(TextFileTest, NoPlantedLinkIsWrittenThrough) {
  const fs::path file = folder_ / "result", target = folder_ / "target";
  WriteWholeFile(target, "mine");
  for (const char* ending : {".part", ".new", ".tmp"}) {
    fs::create_symlink(target, file.string() + ending);
  }
  ReplaceFile(file, "new");
  EXPECT_EQ(ReadWholeFile(file, 100, "text"), "new");
  EXPECT_EQ(ReadWholeFile(target, 100, "text"), "mine");
  fs::remove(file);
  for (const fs::path& planted : {target, folder_ / "nowhere"}) {
    fs::create_symlink(planted, file);
    ASSERT_TRUE(TryReplace(file, "ours", Links::kReplace));
    EXPECT_TRUE(fs::is_regular_file(fs::symlink_status(file)));
    EXPECT_EQ(ReadWholeFile(file, 100, "text"), "ours");
    EXPECT_EQ(ReadWholeFile(target, 100, "text"), "mine");
    fs::remove(file);
  }
  EXPECT_FALSE(fs::exists(folder_ / "nowhere"));
}

TEST_F(TextFileTest, ResultsHaveTheUsualModeOrKeepTheirOwn) {
  const fs::path file = folder_ / "result", link = folder_ / "link";
  const auto mode = [](const fs::path& path) {
    return static_cast<unsigned>(fs::status(path).permissions());
  };
  const mode_t before = umask(027);
  ReplaceFile(file, "new");
  EXPECT_EQ(mode(file), 0640U);
  for (const unsigned own : {0600U, 0666U, 0751U}) {
    fs::permissions(file, fs::perms{own});
    ReplaceFile(file, "newer");
    EXPECT_EQ(mode(file), own);
  }
  fs::create_symlink(file, link);
  ASSERT_TRUE(TryReplace(link, "ours", Links::kReplace));
  EXPECT_EQ(mode(link), 0640U) << "not that of a planted link, or of what is behind it";
  umask(before);
}

TEST_F(TextFileTest, WhetherAFileCanBeWrittenLeavesNoTrace) {
  RequireWritable({});
  RequireWritable(folder_ / "new");
  EXPECT_FALSE(fs::exists(folder_ / "new")) << "only looked";
  WriteWholeFile(folder_ / "old", "kept");
  RequireWritable(folder_ / "old");
  EXPECT_EQ(ReadWholeFile(folder_ / "old", 4, "text"), "kept");
  EXPECT_THROW(RequireWritable(folder_ / "no" / "file"), std::invalid_argument);
  fs::create_symlink(folder_ / "nowhere", folder_ / "dangling");
  RequireWritable(folder_ / "dangling");
  EXPECT_EQ(Names(), (std::set<std::string>{"dangling", "old"}));
}

TEST_F(TextFileTest, APipeIsWrittenToWhereSomebodyReads) {
  const std::string pipe = (folder_ / "pipe").string();
  ASSERT_EQ(mkfifo(pipe.c_str(), 0600), 0);
  EXPECT_THROW(RequireWritable(pipe), std::invalid_argument);
  const int reader = open(pipe.c_str(), O_RDONLY | O_NONBLOCK);
  RequireWritable(pipe);
  const auto descriptors = [] {
    return std::distance(fs::directory_iterator("/proc/self/fd"), fs::directory_iterator());
  };
  const auto before = descriptors();
  WriteWholeFile(pipe, "read");
  EXPECT_EQ(descriptors(), before) << "who writes each second shall not run out of them";
  std::array<char, 8> bytes{};
  EXPECT_EQ(read(reader, bytes.data(), bytes.size()), 4);
  EXPECT_EQ(read(reader, bytes.data(), bytes.size()), -1) << "its end, before the program's";
  close(reader);
  EXPECT_THROW(ReplaceFile(pipe, "lost"), std::runtime_error) << "who read it has left";
}

TEST_F(TextFileTest, WhatIsReplacedStaysWhatItWas) {
  const auto file = folder_ / "file", link = folder_ / "link", device = folder_ / "device";
  WriteWholeFile(file, "old");
  std::filesystem::create_symlink(file, link);
  std::filesystem::create_symlink("/dev/null", device);
  ReplaceFile(link, "new");
  EXPECT_TRUE(std::filesystem::is_symlink(link));
  EXPECT_EQ(ReadWholeFile(file, 100, "text"), "new");
  ReplaceFile(device, "nowhere");
  EXPECT_TRUE(std::filesystem::is_symlink(device));
  EXPECT_TRUE(std::filesystem::is_character_file(device));
  EXPECT_THROW(ReplaceFile(folder_, "a folder"), std::runtime_error);
}

TEST_F(TextFileTest, ReadsNoMoreThanIsSaid) {
  WriteWholeFile(folder_ / "a", std::string((1 << 20) + 1, 'a'));
  EXPECT_THAT([&] { ReadWholeFile(folder_ / "a", 1 << 20, "a rig"); },
              testing::ThrowsMessage<InputError>(
                  HasSubstr("a: too large: accepted is a rig of at most 1 MiB")));
  for (const fs::path& file : {fs::path("/dev/zero"), folder_, folder_ / "none"}) {
    EXPECT_THAT([&] { ReadWholeFile(file, 1 << 20, "a rig"); },
                testing::ThrowsMessage<InputError>(HasSubstr(": cannot be read")));
  }
}

TEST_F(TextFileTest, AnInputIsRecognisedByEveryPath) {
  const fs::path scene = folder_ / "scene.yaml";
  WriteWholeFile(scene, "name: a");
  fs::create_symlink(scene, folder_ / "soft.yaml");
  fs::create_hard_link(scene, folder_ / "hard.yaml");
  for (const fs::path& out : {scene, folder_ / ".." / folder_.filename() / "scene.yaml",
                              folder_ / "soft.yaml", folder_ / "hard.yaml"}) {
    EXPECT_EQ(Refusal(out, scene), "--out " + out.string() + ": accepted is another file than " +
                                       scene.string() + ", which is read");
  }
  WriteWholeFile(folder_ / "other.yaml", "name: a");
  for (const fs::path& out : {fs::path(), folder_ / "other.yaml", folder_ / "new.yaml"}) {
    EXPECT_EQ(Refusal(out, scene), "");
  }
}

TEST_F(TextFileTest, AnInputIsRecognisedInAFolder) {
  WriteWholeFile(folder_ / "rows.csv", "a");
  const std::array inputs{folder_ / "rows.csv"};
  EXPECT_THROW(RequireOtherThan("--out", folder_, {"other.csv", "rows.csv"}, inputs),
               std::invalid_argument);
  EXPECT_NO_THROW(RequireOtherThan("--out", folder_, {"other.csv"}, inputs));
}

}  // namespace
}  // namespace palpate
