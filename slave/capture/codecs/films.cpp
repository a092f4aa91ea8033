#include <cstdlib>
#include <stdexcept>

#include <dlfcn.h>

#include "shared/program/program.h"
#include "slave/capture/codecs/codecs.h"

namespace palpate {
namespace {

struct Module {
  const char* file;
  const char* symbol;
  const char* what;
  const char* built_where;
};
constexpr Module kFilms{"palpate-films.so", "palpate_films",
                        "videos, cameras and images other than PNG and JPEG",
                        "OpenCV's videoio and imgcodecs are installed (package palpate-cameras, or "
                        "deploy/install.sh films)"};
constexpr Module kOpenNi{
    "palpate-openni.so", "palpate_openni", "depth cameras of OpenNI2",
    "OpenNI2 is installed (package palpate-cameras, or deploy/install.sh openni)"};

void* Load(const Module& module) {
  const auto refuse = [&](const std::string& why) {
    throw std::runtime_error(std::string(module.what) + " need " + module.file + ", " + why);
  };
  const auto file = FindPart(module.file);
  if (file.empty()) {
    refuse(std::string("which is not installed next to this program; the build makes it where ") +
           module.built_where);
  }
  void* const loaded = dlopen(file.c_str(), RTLD_NOW | RTLD_LOCAL);
  if (loaded == nullptr) refuse(std::string("which cannot be loaded: ") + dlerror());
  void* const symbol = dlsym(loaded, module.symbol);
  if (symbol == nullptr) refuse("which is not a module of this program: " + file.string());
  return symbol;
}

const Films* LoadFilmsModule() {
  // Read by OpenCV while it is loaded: its own limits are a thousand million pixels, and ten
  // seconds for a camera that froze.
  setenv("OPENCV_IO_MAX_IMAGE_PIXELS", std::to_string(kMostPixels).c_str(), 0);
  setenv("OPENCV_VIDEOIO_V4L_SELECT_TIMEOUT", "1", 0);
  return reinterpret_cast<const Films* (*)()>(Load(kFilms))();
}

}  // namespace

const Films& LoadFilms() {
  static const Films* const films = LoadFilmsModule();
  return *films;
}

std::unique_ptr<Film> OpenDepthCamera(int device) {
  static void* const open = Load(kOpenNi);
  return std::unique_ptr<Film>(reinterpret_cast<Film* (*)(int)>(open)(device));
}

}  // namespace palpate
