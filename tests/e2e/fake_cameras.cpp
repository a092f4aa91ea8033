// Takes the place of palpate-films.so and palpate-openni.so beside the slave, under either name:
// cameras whose pictures come by TCP. PALPATE_FAKE_CAMERA says from where and how large:
// `PORT WIDTH HEIGHT`, rows of 8 bit grey; of a depth camera `PORT WIDTH HEIGHT`, of 16 bit.
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

class FakeCamera final : public Film {
 public:
  explicit FakeCamera(int type) : type_(type) {
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
    cv::Mat picture(height_, width_, type_);
    const std::size_t size = picture.total() * picture.elemSize();
    for (std::size_t got = 0; got < size;) {
      const auto part = recv(socket_, picture.data + got, size - got, 0);
      if (part <= 0) return {};
      got += static_cast<std::size_t>(part);
    }
    return picture;
  }

 private:
  const int type_;
  const int socket_ = socket(AF_INET, SOCK_STREAM, 0);
  int width_ = 0, height_ = 0;
  bool is_there_ = false;
};

std::unique_ptr<Film> Open(int type) {
  auto camera = std::make_unique<FakeCamera>(type);
  return camera->is_there() ? std::move(camera) : nullptr;
}

class FakeFilms final : public Films {
 public:
  [[nodiscard]] std::unique_ptr<Film> OpenFile(const std::string& /*file*/) const override {
    return nullptr;
  }
  [[nodiscard]] std::unique_ptr<Film> OpenDevice(int /*device*/, const cv::Size& /*size*/,
                                                 double /*rate*/) const override {
    return Open(CV_8UC1);
  }
  [[nodiscard]] std::unique_ptr<Film> OpenUrl(
      const std::string& /*address*/, std::chrono::milliseconds /*patience*/) const override {
    return nullptr;
  }
  [[nodiscard]] cv::Mat Decode(Bytes /*bytes*/) const override { return {}; }
};

}  // namespace
}  // namespace palpate

extern "C" const palpate::Films* palpate_films() {
  static const palpate::FakeFilms films;
  return &films;
}

extern "C" palpate::Film* palpate_openni(int /*device*/) {
  return palpate::Open(CV_16UC1).release();
}
