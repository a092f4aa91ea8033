// Reference throughout: OpenCV's imgcodecs, which read and wrote these images before and uses the
// same libraries: no pixel may differ.
#include "slave/capture/codecs/codecs.h"

#include <csetjmp>

#include <gmock/gmock.h>
#include <gtest/gtest.h>
#include <opencv2/core.hpp>
#include <opencv2/imgcodecs.hpp>
#include <png.h>

#include "tests/support/thrown.h"

namespace palpate {
namespace {

using Buffer = std::vector<unsigned char>;

cv::Mat Decode(const std::string& coded) {
  return cv::imdecode(Buffer(coded.begin(), coded.end()), cv::IMREAD_UNCHANGED);
}

// Returns the image as OpenCV reads it, without alpha.
cv::Mat Expected(const Buffer& bytes) {
  const cv::Mat image = cv::imdecode(bytes, cv::IMREAD_UNCHANGED);
  if (image.channels() != 4) return image;
  std::vector<cv::Mat> channels;
  cv::split(image, channels);
  channels.pop_back();
  cv::Mat colour;
  cv::merge(channels, colour);
  return colour;
}

void ExpectSamePixels(const cv::Mat& read, const cv::Mat& expected, const std::string& which) {
  ASSERT_FALSE(expected.empty()) << which;
  ASSERT_EQ(read.type(), expected.type()) << which;
  ASSERT_EQ(read.size(), expected.size()) << which;
  EXPECT_EQ(cv::norm(read, expected, cv::NORM_INF), 0) << which;
}

cv::Mat NoisePixels(int type, const cv::Size& size = {61, 47}) {
  cv::Mat image(size, type);
  cv::RNG(7).fill(image, cv::RNG::UNIFORM, 0, CV_MAT_DEPTH(type) == CV_16U ? 65536 : 256);
  return image;
}

struct PngKind {
  int colour, depth;
  bool transparent = false;
};

// Noise as a PNG of any kind, written by libpng; OpenCV writes only some.
Buffer PngOf(const PngKind& kind, bool interlaced) {
  constexpr int kColumns = 61, kRows = 47;
  Buffer out;
  png_structp png = png_create_write_struct(PNG_LIBPNG_VER_STRING, nullptr, nullptr, nullptr);
  png_infop info = png_create_info_struct(png);
  const auto put = [](png_structp to, png_bytep bytes, std::size_t count) {
    auto* buffer = static_cast<Buffer*>(png_get_io_ptr(to));
    buffer->insert(buffer->end(), bytes, bytes + count);
  };
  png_set_write_fn(png, &out, put, [](png_structp) {});
  png_set_IHDR(png, info, kColumns, kRows, kind.depth, kind.colour,
               interlaced ? PNG_INTERLACE_ADAM7 : PNG_INTERLACE_NONE, PNG_COMPRESSION_TYPE_DEFAULT,
               PNG_FILTER_TYPE_DEFAULT);
  std::vector<png_color> palette(std::size_t{1} << std::min(kind.depth, 8));
  for (std::size_t i = 0; i < palette.size(); ++i) {
    palette[i] = {static_cast<png_byte>(31 * i), static_cast<png_byte>(7 * i + 3),
                  static_cast<png_byte>(251 * i + 9)};
  }
  if (kind.colour == PNG_COLOR_TYPE_PALETTE) {
    png_set_PLTE(png, info, palette.data(), static_cast<int>(palette.size()));
  }
  png_byte alphas[2] = {0, 128};
  png_color_16 clear{1, 1, 1, 1, 1};
  if (kind.transparent) png_set_tRNS(png, info, alphas, 2, &clear);
  png_set_gAMA(png, info, 0.5);
  png_write_info(png, info);
  cv::Mat rows = NoisePixels(CV_8UC1, {static_cast<int>(png_get_rowbytes(png, info)), kRows});
  std::vector<png_bytep> pointers;
  for (int y = 0; y < kRows; ++y) pointers.push_back(rows.ptr(y));
  png_write_image(png, pointers.data());
  png_write_end(png, info);
  png_destroy_write_struct(&png, &info);
  return out;
}

TEST(OpenPngTest, EveryKindOfPngIsReadAsOpenCvReadsIt) {
  std::vector<PngKind> kinds;
  for (const int depth : {1, 2, 4, 8, 16}) {
    kinds.push_back({PNG_COLOR_TYPE_GRAY, depth});
    kinds.push_back({PNG_COLOR_TYPE_GRAY, depth, true});
    if (depth <= 8) kinds.push_back({PNG_COLOR_TYPE_PALETTE, depth});
    if (depth <= 8) kinds.push_back({PNG_COLOR_TYPE_PALETTE, depth, true});
    if (depth < 8) continue;
    kinds.push_back({PNG_COLOR_TYPE_RGB, depth});
    kinds.push_back({PNG_COLOR_TYPE_RGB, depth, true});
    kinds.push_back({PNG_COLOR_TYPE_RGB_ALPHA, depth});
    kinds.push_back({PNG_COLOR_TYPE_GRAY_ALPHA, depth});
  }
  for (const PngKind& kind : kinds) {
    for (const bool interlaced : {false, true}) {
      const Buffer bytes = PngOf(kind, interlaced);
      const auto image = OpenPng(bytes);
      ASSERT_TRUE(image);
      EXPECT_EQ(image->size(), cv::Size(61, 47));
      ExpectSamePixels(image->Decode(), Expected(bytes),
                       cv::format("colour type %d, %d bit, transparent %d, interlaced %d",
                                  kind.colour, kind.depth, kind.transparent, interlaced));
    }
  }
}

// Sampling 4:2:0 with fancy upsampling and the accurate integer transform, as OpenCV decodes.
TEST(OpenJpegTest, JpegsAreReadAsOpenCvReadsThem) {
  for (const int type : {CV_8UC1, CV_8UC3}) {
    for (const int progressive : {0, 1}) {
      for (const int quality : {20, 90, 100}) {
        Buffer bytes;
        ASSERT_TRUE(cv::imencode(
            ".jpg", NoisePixels(type), bytes,
            {cv::IMWRITE_JPEG_QUALITY, quality, cv::IMWRITE_JPEG_PROGRESSIVE, progressive}));
        const auto image = OpenJpeg(bytes);
        ASSERT_TRUE(image);
        EXPECT_EQ(image->size(), cv::Size(61, 47));
        ExpectSamePixels(image->Decode(), Expected(bytes), cv::format("quality %d", quality));
      }
    }
  }
}

// A file that is cut anywhere is refused. The two bytes of a JPEG's end marker hold no pixel; some
// cameras leave them out.
TEST(OpenImageTest, NoCutFileIsRead) {
  for (const std::string format : {".png", ".jpg"}) {
    Buffer bytes;
    ASSERT_TRUE(cv::imencode(format, NoisePixels(CV_8UC3, {20, 16}), bytes));
    const std::size_t end = bytes.size() - (format == ".jpg" ? 2 : 0);
    for (std::size_t kept = 8; kept < end; ++kept) {
      const std::string complaint = Thrown<std::exception>([&] {
        const Bytes cut(bytes.data(), kept);
        (format == ".png" ? OpenPng(cut) : OpenJpeg(cut))->Decode();
      });
      EXPECT_EQ(complaint, "is truncated") << format << " after " << kept << " bytes";
    }
  }
}

// libjpeg continues after damage and shows grey or earlier content.
TEST(OpenImageTest, DamagedPixelsAreRefusedWithoutOtherWords) {
  for (const std::string format : {".png", ".jpg"}) {
    Buffer bytes;
    ASSERT_TRUE(cv::imencode(format, NoisePixels(CV_8UC1), bytes));
    const auto middle = bytes.begin() + static_cast<std::ptrdiff_t>(bytes.size() / 2);
    std::fill(middle, middle + 40, static_cast<unsigned char>(0xff));
    testing::internal::CaptureStderr();
    const std::string complaint = Thrown<std::exception>(
        [&] { (format == ".png" ? OpenPng(bytes) : OpenJpeg(bytes))->Decode(); });
    EXPECT_EQ(testing::internal::GetCapturedStderr(), "") << format;
    EXPECT_THAT(complaint, testing::StartsWith("is damaged: ")) << format;
  }
}

TEST(EncodePngTest, ImagesSurviveTheRoundTrip) {
  for (const int type : {CV_8UC1, CV_8UC3, CV_16UC1, CV_16UC3}) {
    const cv::Mat whole = NoisePixels(type), part = whole(cv::Rect(3, 5, 40, 30));
    ExpectSamePixels(Decode(EncodePng(whole)), whole, cv::typeToString(type));
    ExpectSamePixels(Decode(EncodePng(part)), part, "rows apart");
  }
  EXPECT_THAT(Thrown<std::exception>([] { EncodePng(cv::Mat(4, 5, CV_32FC1)); }),
              testing::HasSubstr("PNG"));
}

}  // namespace
}  // namespace palpate
