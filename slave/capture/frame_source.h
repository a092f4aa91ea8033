// Where pictures come from: files, a video, a camera, the simulated site. One interface; the
// pipeline cannot tell.
#pragma once

#include <cstdint>
#include <functional>
#include <memory>
#include <optional>
#include <stop_token>
#include <string>

#include <opencv2/core/mat.hpp>

#include "shared/state/clock.h"
#include "slave/scene/scene.h"

namespace palpate {

struct Frame {
  cv::Mat image;  // 1 or 3 channels, 8 or 16 bit; straight, if the scene names the camera's lens
  std::uint64_t sequence = 0;  // from 1
  Time sensed_at{};            // when the picture was taken (middle of the exposure)
};

class FrameSource {
 public:
  virtual ~FrameSource() = default;
  FrameSource() = default;
  FrameSource(const FrameSource&) = delete;
  FrameSource& operator=(const FrameSource&) = delete;
  // The next picture; blocks until there is one. nullopt: the source has ended or `stop` was
  // requested. Throws std::runtime_error where a source breaks (unreadable file, camera gone); the
  // message names it.
  virtual std::optional<Frame> Next(const std::stop_token& stop) = 0;
  // In words, for people: `files frames/%04d.png (120)`.
  [[nodiscard]] virtual std::string description() const = 0;
};

// Never given an empty picture; throws std::runtime_error where it cannot take one.
using PictureFilter = std::function<cv::Mat(const cv::Mat&)>;

// Opens what the scene names (files, video, device); relative paths are relative to the scene file.
// `paced`: pictures come at the scene's rate; otherwise as fast as they are read, with stamps at
// that rate. `filter`: what the decoding thread makes of each picture, if anything; files and
// videos try it on the first one at once. Throws std::runtime_error: nothing matches, unreadable,
// no such camera, a picture that the filter refuses. Not for Source::kSimulated.
std::unique_ptr<FrameSource> OpenFrameSource(const Scene& scene, bool paced,
                                             const PictureFilter& filter = {});

}  // namespace palpate
