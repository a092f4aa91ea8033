// PNG and JPEG in memory, libpng and libjpeg being called here and nowhere else; and what the
// module palpate-films adds to them.
//
// A picture is 8 or 16 bit, grey or blue, green, red, as OpenCV's imgcodecs reads and writes it
// with IMREAD_UNCHANGED; alpha is left out.
#pragma once

#include <chrono>
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

// What the module palpate-films adds to PNG and JPEG: films, cameras and other formats of pictures,
// through OpenCV's videoio and imgcodecs. They bring some 220 shared libraries, 0.1 s and 50 MB to
// every start, so that the module is loaded when a scene first asks for one of them.
class Film {
 public:
  virtual ~Film() = default;
  Film() = default;
  Film(const Film&) = delete;
  Film& operator=(const Film&) = delete;
  // The next picture, in memory of its own; empty: there is none.
  virtual cv::Mat Next() = 0;
  // Of depth: what one count is [m]; 0: not told.
  [[nodiscard]] virtual double unit() const { return 0; }
};

class Films {
 public:
  virtual ~Films() = default;
  Films() = default;
  Films(const Films&) = delete;
  Films& operator=(const Films&) = delete;
  // nullptr: not a film.
  [[nodiscard]] virtual std::unique_ptr<Film> OpenFile(const std::string& file) const = 0;
  // The camera /dev/video`device`, asked for `size` [px] (empty: its own) and `rate` [Hz]. nullptr:
  // there is none, or it is not permitted.
  [[nodiscard]] virtual std::unique_ptr<Film> OpenDevice(int device, const cv::Size& size,
                                                         double rate) const = 0;
  // A stream's address (rtsp://, http://, udp://), or a GStreamer pipeline that ends in an appsink.
  // nullptr: nothing answers there within `patience`, which each picture may take, too. Of a
  // pipeline only its own elements know how long they wait.
  [[nodiscard]] virtual std::unique_ptr<Film> OpenUrl(const std::string& address,
                                                      std::chrono::milliseconds patience) const = 0;
  // A picture as it is, alpha and all. Empty: not a picture, damaged, or larger than kMostPixels.
  [[nodiscard]] virtual cv::Mat Decode(Bytes bytes) const = 0;
};

// Loads the module at the first call. Throws std::runtime_error: it is not installed, or cannot be
// loaded (why).
const Films& LoadFilms();

// Depth pictures of the OpenNI2 camera `device`, one channel of 16 bit, as it sees them and not
// mirrored, through the module palpate-openni, loaded at the first call. nullptr: there is no such
// camera, or it measures no depth. Throws
// std::runtime_error as LoadFilms does.
std::unique_ptr<Film> OpenDepthCamera(int device);

}  // namespace palpate
