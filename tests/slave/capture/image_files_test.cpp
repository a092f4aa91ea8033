#include "slave/capture/image_files.h"

#include <stdexcept>

#include <gmock/gmock.h>
#include <gtest/gtest.h>
#include <opencv2/core.hpp>
#include <opencv2/imgcodecs.hpp>
#include <zlib.h>

#include "tests/support/scratch.h"
#include "tests/support/thrown.h"

namespace palpate {
namespace {

std::vector<std::string> Names(const std::string& pattern, const Scratch& scratch) {
  std::vector<std::string> names;
  for (const auto& file : ListImages(pattern, scratch.path())) {
    names.push_back(file.filename().string());
  }
  return names;
}

TEST(ListImagesTest, GlobsAndDirectoriesComeInTheOrderOfTheirNumbers) {
  const Scratch scratch;
  for (const char* name : {"f10.png", "f2.png", "f1.png", "note.txt", ".f3.png"}) {
    scratch.Write(name, "x");
  }
  EXPECT_THAT(Names("f*.png", scratch), testing::ElementsAre("f1.png", "f2.png", "f10.png"));
  EXPECT_THAT(Names("f?.png", scratch), testing::ElementsAre("f1.png", "f2.png"));
  EXPECT_THAT(Names("f2.png", scratch), testing::ElementsAre("f2.png"));
  std::filesystem::remove(scratch.path() / ".f3.png");
  EXPECT_THAT(Names(".", scratch), testing::ElementsAre("f1.png", "f2.png", "f10.png"));
}

TEST(InstantsTest, AMissingNumberIsAGapInTime) {
  using testing::ElementsAre;
  EXPECT_THAT(InstantsOf({"f08.png", "f09.png", "f12.png"}), ElementsAre(0, 1, 4));
  EXPECT_THAT(InstantsOf({"f0.png", "f5.png", "f15.png"}), ElementsAre(0, 1, 3)) << "every fifth";
  EXPECT_EQ(MissingInWords({0, 1, 4}), ", 2 missing");
  EXPECT_EQ(MissingInWords({0, 1, 2}), "");
}

TEST(InstantsTest, NumbersThatTellNoTimeAreNotTakenForOne) {
  using testing::ElementsAre;
  EXPECT_THAT(InstantsOf({"a.png", "b.png"}), ElementsAre(0, 1)) << "no numbers";
  EXPECT_THAT(InstantsOf({"f1.png", "f3.png", "f6.png"}), ElementsAre(0, 1, 2)) << "no common step";
  EXPECT_THAT(InstantsOf({"f1.png", "f2.png", "f900.png"}), ElementsAre(0, 1, 2)) << "two takes";
  EXPECT_THAT(InstantsOf({"left1.png", "right1.png"}), ElementsAre(0, 1)) << "not rising";
  EXPECT_THAT(InstantsOf({"f99999999999999999999998.png", "f99999999999999999999999.png"}),
              ElementsAre(0, 1));
  EXPECT_THAT(InstantsOf({}), ElementsAre());
}

TEST(ReadImageTest, WhatIsNoImageIsRefusedByNameAndNumber) {
  const Scratch scratch;
  std::vector<unsigned char> bytes;
  ASSERT_TRUE(cv::imencode(".jpg", cv::Mat(96, 128, CV_8UC1, cv::Scalar(9)), bytes));
  const std::string whole(bytes.begin(), bytes.end());
  const auto message = [](const std::filesystem::path& file, int number) {
    return Thrown<std::runtime_error>([&] { ReadImage(file, number); });
  };
  EXPECT_THAT(message(scratch.Write("cut.jpg", whole.substr(0, whole.size() / 2)), 12),
              testing::HasSubstr("cut.jpg: image 12"));
  EXPECT_THAT(message(scratch.Write("text.png", "not an image"), 3),
              testing::HasSubstr("image 3 is not an image"));
  EXPECT_THAT(message(scratch.path() / "none.png", 4),
              testing::HasSubstr("image 4 cannot be opened"));
}

// Returns a PNG header with this size and without pixels: 16 bit, three colours and alpha.
std::string PngHeader(std::uint32_t width, std::uint32_t height) {
  const auto number = [](std::uint32_t n) {
    std::string bytes;
    for (const int shift : {24, 16, 8, 0}) bytes += static_cast<char>(n >> shift & 0xff);
    return bytes;
  };
  const std::string chunk =
      "IHDR" + number(width) + number(height) + std::string("\x10\x06\0\0\0", 5);
  const auto* const bytes = reinterpret_cast<const Bytef*>(chunk.data());
  const auto checksum =
      static_cast<std::uint32_t>(crc32(0, bytes, static_cast<uInt>(chunk.size())));
  return "\x89PNG\r\n\x1a\n" + number(13) + chunk + number(checksum) + number(100) + "IDAT";
}

// An image of 16384 x 16384 px would need 2.1 GB, one of 8192 x 8192 px 0.5 GB.
TEST(ReadImageTest, SizesAreJudgedBeforePixelsTakeMemory) {
  const Scratch scratch;
  const auto huge = scratch.Write("huge.png", PngHeader(16384, 16384));
  EXPECT_THAT(Thrown<std::runtime_error>([&] { ReadImage(huge, 2); }),
              testing::HasSubstr("huge.png: image 2 is 16384 x 16384 px: expected at most"));
  const auto large = scratch.Write("large.png", PngHeader(8192, 8192));
  const AcceptSize refuse = [](const cv::Size& size) {
    throw std::runtime_error("not " + std::to_string(size.width));
  };
  EXPECT_EQ(Thrown<std::runtime_error>([&] { ReadImage(large, 2, refuse); }), "not 8192");
}

}  // namespace
}  // namespace palpate
