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

  // Returns the error message if `out` would overwrite `input`.
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

// Bytes that are invalid in a message: incomplete characters, overlong ones, surrogates, code
// points beyond Unicode. A short text is not shortened.
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
TEST(PresentableTest, ContainsNoCursorOrDirectionControls) {
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

TEST_F(TextFileTest, ReadsNoMoreThanIsStated) {
  WriteWholeFile(folder_ / "a", std::string((1 << 20) + 1, 'a'));
  EXPECT_THAT([&] { ReadWholeFile(folder_ / "a", 1 << 20, "a rig"); },
              testing::ThrowsMessage<InputError>(
                  HasSubstr("a: too large: expected a rig of at most 1 MiB")));
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
    EXPECT_EQ(Refusal(out, scene), "--out " + out.string() + ": expected another file than " +
                                       scene.string() + ", which is read");
  }
  WriteWholeFile(folder_ / "other.yaml", "name: a");
  for (const fs::path& out : {fs::path(), folder_ / "other.yaml", folder_ / "new.yaml"}) {
    EXPECT_EQ(Refusal(out, scene), "");
  }
}

}  // namespace
}  // namespace palpate
