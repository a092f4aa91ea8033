// PNG and JPEG in memory: libpng and libjpeg are called here and nowhere else.
//
// A picture is 8 or 16 bit, grey or blue, green, red, as OpenCV's imgcodecs reads and writes it
// with IMREAD_UNCHANGED; alpha is left out.
#pragma once

#include <memory>
#include <span>
#include <string>

#include <opencv2/core/mat.hpp>

namespace palpate {

using Bytes = std::span<const unsigned char>;

// Larger pictures are refused by their header: 16 bits of three colours take 600 MB then, and no
// camera that looks at a soft object has as many.
inline constexpr long kMostPixels = 100'000'000;

// A picture whose header has been read: its size is known before its pixels take memory.
class CodedPicture {
 public:
  virtual ~CodedPicture() = default;
  CodedPicture() = default;
  CodedPicture(const CodedPicture&) = delete;
  CodedPicture& operator=(const CodedPicture&) = delete;

  [[nodiscard]] virtual cv::Size size() const = 0;  // [px]
  // The pixels; once. Throws std::runtime_error that continues "the picture ...": is truncated, is
  // damaged and where; then nothing of it can be trusted.
  virtual cv::Mat Decode() = 0;
};

// `bytes` must outlive what is opened. nullptr: not a PNG; not a JPEG of grey or three colours.
// Throw as Decode() does where the header is wrong.
std::unique_ptr<CodedPicture> OpenPng(Bytes bytes);
std::unique_ptr<CodedPicture> OpenJpeg(Bytes bytes);

// The bytes of a file. `image`: 1 or 3 channels of 8 or 16 bit; of 16 bit JPEG keeps the upper
// byte. `quality` 1..100: more is better and larger. Throw std::invalid_argument naming what is
// wrong: an empty picture, another type, a quality out of range; std::runtime_error if the codec
// fails.
std::string EncodePng(const cv::Mat& image);
std::string EncodeJpeg(const cv::Mat& image, int quality);

// What both encoders ask of a picture; `format` is named where it is refused.
void RequireEncodable(const cv::Mat& image, const char* format);

}  // namespace palpate
