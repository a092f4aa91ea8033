// Replaces palpate-cameras.so in the slave's folder by a camera whose images come over TCP.
// PALPATE_FAKE_CAMERA gives port and size as `PORT WIDTH HEIGHT`. Images are rows of 8-bit grey.
#include <cstdio>
#include <cstdlib>
#include <memory>
#include <string>

#include <arpa/inet.h>
#include <sys/socket.h>
#include <unistd.h>

#include "slave/capture/codecs/codecs.h"

namespace palpate {
namespace {

class FakeCamera final : public VideoStream {
 public:
  FakeCamera() {
    int port = 0;
    const char* const setting = std::getenv("PALPATE_FAKE_CAMERA");
    if (setting == nullptr || std::sscanf(setting, "%d %d %d", &port, &width_, &height_) != 3)
      return;
    sockaddr_in there{};
    there.sin_family = AF_INET;
    there.sin_port = htons(static_cast<std::uint16_t>(port));
    there.sin_addr.s_addr = htonl(INADDR_LOOPBACK);
    is_there_ = connect(socket_, reinterpret_cast<sockaddr*>(&there), sizeof there) == 0;
  }
  ~FakeCamera() override { close(socket_); }

  [[nodiscard]] bool is_there() const { return is_there_; }
  cv::Mat Next() override {
    cv::Mat image(height_, width_, CV_8UC1);
    const std::size_t size = image.total() * image.elemSize();
    for (std::size_t got = 0; got < size;) {
      const auto part = recv(socket_, image.data + got, size - got, 0);
      if (part <= 0) return {};
      got += static_cast<std::size_t>(part);
    }
    return image;
  }

 private:
  const int socket_ = socket(AF_INET, SOCK_STREAM, 0);
  int width_ = 0, height_ = 0;
  bool is_there_ = false;
};

class FakeVideoBackend final : public VideoBackend {
 public:
  [[nodiscard]] std::unique_ptr<VideoStream> OpenFile(const std::string& /*file*/) const override {
    return nullptr;
  }
  [[nodiscard]] std::unique_ptr<VideoStream> OpenDevice(int /*device*/, const cv::Size& /*size*/,
                                                        double /*rate*/) const override {
    auto camera = std::make_unique<FakeCamera>();
    return camera->is_there() ? std::move(camera) : nullptr;
  }
  [[nodiscard]] std::unique_ptr<VideoStream> OpenUrl(
      const std::string& /*address*/, std::chrono::milliseconds /*timeout*/) const override {
    return nullptr;
  }
  [[nodiscard]] cv::Mat Decode(Bytes /*bytes*/) const override { return {}; }
};

}  // namespace
}  // namespace palpate

extern "C" const palpate::VideoBackend* palpate_cameras() {
  static const palpate::FakeVideoBackend backend;
  return &backend;
}
