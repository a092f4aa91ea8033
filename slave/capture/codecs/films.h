// What the module palpate-films adds to PNG and JPEG: films, cameras and other formats of pictures,
// through OpenCV's videoio and imgcodecs. They bring some 220 shared libraries, 0.1 s and 50 MB to
// every start, so that the module is loaded when a scene first asks for one of them.
#pragma once

#include <memory>
#include <string>

#include <opencv2/core/mat.hpp>

#include "slave/capture/codecs/codecs.h"

namespace palpate {

class Film {
 public:
  virtual ~Film() = default;
  Film() = default;
  Film(const Film&) = delete;
  Film& operator=(const Film&) = delete;
  // The next picture, in memory of its own; empty: there is none.
  virtual cv::Mat Next() = 0;
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
  // A picture as it is, alpha and all. Empty: not a picture, damaged, or larger than kMostPixels.
  [[nodiscard]] virtual cv::Mat Decode(Bytes bytes) const = 0;
};

// Loads the module at the first call. Throws std::runtime_error: it is not installed, or cannot be
// loaded (why).
const Films& LoadFilms();

}  // namespace palpate
