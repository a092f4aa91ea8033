// The module palpate-openni: see codecs.h.
#include <cstring>
#include <memory>

#include <OpenNI.h>
#include <opencv2/core.hpp>

#include "slave/capture/codecs/codecs.h"

namespace palpate {
namespace {

constexpr int kPatienceMs = 1000;  // for a image, before the camera counts as gone

class OpenNiFilm final : public Film {
 public:
  // False: there is no such camera, or none of depth.
  bool Open(int number) {
    openni::Array<openni::DeviceInfo> devices;
    openni::OpenNI::enumerateDevices(&devices);
    if (number >= devices.getSize() ||
        device_.open(devices[number].getUri()) != openni::STATUS_OK ||
        depth_.create(device_, openni::SENSOR_DEPTH) != openni::STATUS_OK) {
      return false;
    }
    depth_.setMirroringEnabled(false);  // many show a mirror's view unless they are stated
    is_mirrored_ = depth_.getMirroringEnabled();
    unit_ = UnitOf(depth_.getVideoMode().getPixelFormat());
    return unit_ > 0 && depth_.start() == openni::STATUS_OK;
  }
  [[nodiscard]] double unit() const override { return unit_; }
  cv::Mat Next() override {
    openni::VideoStream* streams[] = {&depth_};
    int ready = -1;
    openni::VideoFrameRef frame;
    if (openni::OpenNI::waitForAnyStream(streams, 1, &ready, kPatienceMs) != openni::STATUS_OK ||
        depth_.readFrame(&frame) != openni::STATUS_OK) {
      return {};
    }
    cv::Mat image(frame.getHeight(), frame.getWidth(), CV_16UC1);
    const auto* data = static_cast<const unsigned char*>(frame.getData());
    for (int row = 0; row < image.rows; ++row) {
      std::memcpy(image.ptr(row), data + std::size_t(row) * frame.getStrideInBytes(),
                  image.cols * image.elemSize());
    }
    if (is_mirrored_) cv::flip(image, image, 1);
    return image;
  }

 private:
  // Length of one count [m]; 0: it is no depth.
  static double UnitOf(openni::PixelFormat format) {
    if (format == openni::PIXEL_FORMAT_DEPTH_1_MM) return 1e-3;
    return format == openni::PIXEL_FORMAT_DEPTH_100_UM ? 1e-4 : 0;
  }

  openni::Device device_;
  openni::VideoStream depth_;
  bool is_mirrored_ = false;
  double unit_ = 0;
};

}  // namespace
}  // namespace palpate

extern "C" palpate::Film* palpate_openni(int device) {
  static const bool is_ready = openni::OpenNI::initialize() == openni::STATUS_OK;
  auto film = std::make_unique<palpate::OpenNiFilm>();
  return is_ready && film->Open(device) ? film.release() : nullptr;
}
