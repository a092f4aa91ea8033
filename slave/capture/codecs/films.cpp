#include <cstdlib>
#include <stdexcept>

#include <dlfcn.h>

#include "shared/program/program.h"
#include "slave/capture/codecs/codecs.h"

namespace palpate {
namespace {

constexpr const char* kModule = "palpate-films.so";

[[noreturn]] void Refuse(const std::string& why) {
  throw std::runtime_error("films, cameras and pictures other than PNG and JPEG need " +
                           std::string(kModule) + ", " + why);
}

const Films* Load() {
  const auto file = FindPart(kModule);
  if (file.empty()) {
    Refuse(
        "which is not installed beside this program: it is built where OpenCV's videoio and "
        "imgcodecs are (deploy/install.sh films)");
  }
  // Read by OpenCV while it is loaded: its own limit is a thousand million pixels.
  setenv("OPENCV_IO_MAX_IMAGE_PIXELS", std::to_string(kMostPixels).c_str(), 0);
  void* const module = dlopen(file.c_str(), RTLD_NOW | RTLD_LOCAL);
  if (module == nullptr) Refuse(std::string("which cannot be loaded: ") + dlerror());
  void* const symbol = dlsym(module, "palpate_films");
  if (symbol == nullptr) Refuse("which is another's: " + file.string());
  return reinterpret_cast<const Films* (*)()>(symbol)();
}

}  // namespace

const Films& LoadFilms() {
  static const Films* const films = Load();
  return *films;
}

}  // namespace palpate
