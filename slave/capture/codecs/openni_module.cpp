// The module palpate-openni: see codecs.h.
#include <cstring>

#include <OpenNI.h>
#include <opencv2/core/mat.hpp>

#include "slave/capture/codecs/codecs.h"

namespace palpate {
namespace {

constexpr int kPatienceMs = 1000;  // for a picture, before the camera counts as gone

class OpenNiFilm final : public Film {
 public:
  // False: there is no such camera.
  bool Open(int number) {
    openni::Array<openni::DeviceInfo> devices;
    openni::OpenNI::enumerateDevices(&devices);
    return number < devices.getSize() &&
           device_.open(devices[number].getUri()) == openni::STATUS_OK &&
           depth_.create(device_, openni::SENSOR_DEPTH) == openni::STATUS_OK &&
           depth_.start() == openni::STATUS_OK;
  }
  cv::Mat Next() override {
    openni::VideoStream* streams[] = {&depth_};
    int ready = -1;
    openni::VideoFrameRef frame;
    if (openni::OpenNI::waitForAnyStream(streams, 1, &ready, kPatienceMs) != openni::STATUS_OK ||
        depth_.readFrame(&frame) != openni::STATUS_OK) {
      return {};
    }
    cv::Mat picture(frame.getHeight(), frame.getWidth(), CV_16UC1);
    const auto* data = static_cast<const unsigned char*>(frame.getData());
    for (int row = 0; row < picture.rows; ++row) {
      std::memcpy(picture.ptr(row), data + std::size_t(row) * frame.getStrideInBytes(),
                  picture.cols * picture.elemSize());
    }
    return picture;
  }

 private:
  openni::Device device_;
  openni::VideoStream depth_;
};

}  // namespace
}  // namespace palpate

extern "C" palpate::Film* palpate_openni(int device) {
  static const bool is_ready = openni::OpenNI::initialize() == openni::STATUS_OK;
  auto film = std::make_unique<palpate::OpenNiFilm>();
  return is_ready && film->Open(device) ? film.release() : nullptr;
}
