// The module palpate-cameras: see codecs.h.
#include <opencv2/core.hpp>
#include <opencv2/imgcodecs.hpp>
#include <opencv2/videoio.hpp>

#include "slave/capture/codecs/codecs.h"

namespace palpate {
namespace {

class OpenCvVideo final : public VideoStream {
 public:
  explicit OpenCvVideo(const cv::VideoCapture& capture) : capture_(capture) {}
  cv::Mat Next() override {
    cv::Mat image;
    return capture_.read(image) ? image : cv::Mat();
  }

 private:
  cv::VideoCapture capture_;
};

int IgnoreError(int, const char*, const char*, const char*, int, void*) {
  return 0;
}

class OpenCvVideoBackend final : public VideoBackend {
 public:
  // Exceptions state the error; OpenCV would also write it to stderr.
  OpenCvVideoBackend() { cv::redirectError(&IgnoreError); }

  [[nodiscard]] std::unique_ptr<VideoStream> OpenFile(const std::string& file) const override {
    return Opened(cv::VideoCapture(file, cv::CAP_FFMPEG));  // other backends load many libraries
  }
  [[nodiscard]] std::unique_ptr<VideoStream> OpenDevice(int device, const cv::Size& size,
                                                        double rate) const override {
    cv::VideoCapture capture(device, cv::CAP_V4L2);
    if (capture.isOpened() && !size.empty()) {
      capture.set(cv::CAP_PROP_FRAME_WIDTH, size.width);
      capture.set(cv::CAP_PROP_FRAME_HEIGHT, size.height);
    }
    if (!capture.isOpened()) return nullptr;
    capture.set(cv::CAP_PROP_FPS, rate);
    capture.set(cv::CAP_PROP_BUFFERSIZE, 1);
    // Switches automatic exposure and white balance off where the driver allows it: images with
    // corrected light do not show how the light changed.
    constexpr double kManual = 1;  // V4L2's V4L2_EXPOSURE_MANUAL
    capture.set(cv::CAP_PROP_AUTO_EXPOSURE, kManual);
    capture.set(cv::CAP_PROP_AUTO_WB, 0);
    capture.set(cv::CAP_PROP_AUTOFOCUS, 0);
    return Opened(capture);
  }
  [[nodiscard]] std::unique_ptr<VideoStream> OpenUrl(
      const std::string& address, std::chrono::milliseconds timeout) const override {
    // OpenCV closes a pipeline when its timeout is queried, which pipelines do not have.
    if (address.find('!') != std::string::npos) {
      return Opened(cv::VideoCapture(address, cv::CAP_GSTREAMER));
    }
    const int ms = static_cast<int>(timeout.count());
    return Opened(
        cv::VideoCapture(address, cv::CAP_FFMPEG,
                         {cv::CAP_PROP_OPEN_TIMEOUT_MSEC, ms, cv::CAP_PROP_READ_TIMEOUT_MSEC, ms}));
  }
  [[nodiscard]] cv::Mat Decode(Bytes bytes) const override {
    try {
      const cv::Mat file(1, static_cast<int>(bytes.size()), CV_8UC1,
                         const_cast<unsigned char*>(bytes.data()));  // read only
      return cv::imdecode(file, cv::IMREAD_UNCHANGED);
    } catch (const cv::Exception&) {
      return {};
    }
  }

 private:
  static std::unique_ptr<VideoStream> Opened(const cv::VideoCapture& capture) {
    return capture.isOpened() ? std::make_unique<OpenCvVideo>(capture) : nullptr;
  }
};

}  // namespace
}  // namespace palpate

extern "C" const palpate::VideoBackend* palpate_cameras() {
  static const palpate::OpenCvVideoBackend videos;
  return &videos;
}
