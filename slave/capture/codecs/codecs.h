// Decodes and encodes PNG and JPEG in memory. Only this module calls libpng and libjpeg. The module
// palpate-cameras adds other formats.
//
// An image is 8 or 16 bit, grey or blue, green, red, as OpenCV's imgcodecs reads and writes it
// with IMREAD_UNCHANGED; alpha is left out.
#pragma once

#include <chrono>
#include <memory>
#include <span>
#include <string>

#include <opencv2/core/mat.hpp>

namespace palpate {

using Bytes = std::span<const unsigned char>;

// Larger images are rejected by their header: with 16 bit and three colours they would need 600 MB.
inline constexpr long kMaxPixels = 100'000'000;

// An image whose header has been read: its size is known before its pixels need memory.
class CodedImage {
 public:
  virtual ~CodedImage() = default;
  CodedImage() = default;
  CodedImage(const CodedImage&) = delete;
  CodedImage& operator=(const CodedImage&) = delete;

  [[nodiscard]] virtual cv::Size size() const = 0;  // [px]
  // Decodes the pixels. May be called once. Throws std::runtime_error whose text continues "the
  // image ...": is truncated, is damaged and where. The content is then not usable.
  virtual cv::Mat Decode() = 0;
};

// `bytes` must outlive the result. nullptr: not a PNG; not a JPEG with grey or three colours. Throw
// as Decode() does if the header is invalid.
std::unique_ptr<CodedImage> OpenPng(Bytes bytes);
std::unique_ptr<CodedImage> OpenJpeg(Bytes bytes);

// The bytes of a file. `image`: 1 or 3 channels of 8 or 16 bit; a JPEG keeps the upper byte of 16
// bit. `quality` 1..100: higher is better and larger. Throw std::invalid_argument with the reason:
// an empty image, another type, a quality out of range; std::runtime_error if the codec fails.
std::string EncodePng(const cv::Mat& image);
std::string EncodeJpeg(const cv::Mat& image, int quality);

// Requirements of both encoders for an image; `format` is named in the error.
void RequireEncodable(const cv::Mat& image, const char* format);

// The module palpate-cameras: videos, cameras and further image formats, through OpenCV's videoio
// and imgcodecs. These need some 220 shared libraries, 0.1 s and 50 MB at a start, so the module is
// loaded when a scene first needs it.
class VideoStream {
 public:
  virtual ~VideoStream() = default;
  VideoStream() = default;
  VideoStream(const VideoStream&) = delete;
  VideoStream& operator=(const VideoStream&) = delete;
  // The next image, with its own memory; empty: there is none.
  virtual cv::Mat Next() = 0;
};

class VideoBackend {
 public:
  virtual ~VideoBackend() = default;
  VideoBackend() = default;
  VideoBackend(const VideoBackend&) = delete;
  VideoBackend& operator=(const VideoBackend&) = delete;
  // nullptr: not a video.
  [[nodiscard]] virtual std::unique_ptr<VideoStream> OpenFile(const std::string& file) const = 0;
  // The camera /dev/video`device`, with requested `size` [px] (empty: its default) and `rate` [Hz].
  // nullptr: no such camera, or no permission.
  [[nodiscard]] virtual std::unique_ptr<VideoStream> OpenDevice(int device, const cv::Size& size,
                                                                double rate) const = 0;
  // Opens a stream's address (rtsp://, http://, udp://), or a GStreamer pipeline that ends in an
  // appsink. nullptr: no answer within `timeout`, which applies to each image as well. A pipeline's
  // own elements define its timeouts.
  [[nodiscard]] virtual std::unique_ptr<VideoStream> OpenUrl(
      const std::string& address, std::chrono::milliseconds timeout) const = 0;
  // Reads an image unchanged, including alpha. Empty: not an image, damaged, or larger than
  // kMaxPixels.
  [[nodiscard]] virtual cv::Mat Decode(Bytes bytes) const = 0;
};

// Loads the module at the first call. Throws std::runtime_error: it is not installed, or cannot be
// loaded (why).
const VideoBackend& LoadVideoBackend();

}  // namespace palpate
