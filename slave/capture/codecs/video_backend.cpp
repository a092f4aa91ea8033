#include <cstdlib>
#include <stdexcept>

#include <dlfcn.h>

#include "shared/program/program.h"
#include "slave/capture/codecs/codecs.h"

namespace palpate {
namespace {

constexpr const char* kModule = "palpate-cameras.so";

// The function `palpate_cameras` of the module.
void* LoadSymbol() {
  const auto refuse = [](const std::string& why) {
    throw std::runtime_error("videos, cameras and images other than PNG and JPEG need " +
                             std::string(kModule) + ", " + why);
  };
  const auto file = FindPart(kModule);
  if (file.empty()) {
    refuse(
        "which is not installed next to this program; the build makes it where OpenCV's videoio "
        "and imgcodecs are installed (package palpate-cameras, or deploy/install.sh cameras)");
  }
  void* const loaded = dlopen(file.c_str(), RTLD_NOW | RTLD_LOCAL);
  if (loaded == nullptr) refuse(std::string("which cannot be loaded: ") + dlerror());
  void* const symbol = dlsym(loaded, "palpate_cameras");
  if (symbol == nullptr) refuse("which is not a module of this program: " + file.string());
  return symbol;
}

const VideoBackend* LoadVideoModule() {
  // Read by OpenCV while it is loaded: its own limits are a thousand million pixels, and ten
  // seconds for a camera that froze.
  setenv("OPENCV_IO_MAX_IMAGE_PIXELS", std::to_string(kMaxPixels).c_str(), 0);
  setenv("OPENCV_VIDEOIO_V4L_SELECT_TIMEOUT", "1", 0);
  return reinterpret_cast<const VideoBackend* (*)()>(LoadSymbol())();
}

}  // namespace

const VideoBackend& LoadVideoBackend() {
  static const VideoBackend* const videos = LoadVideoModule();
  return *videos;
}

}  // namespace palpate
