// Where pictures and pairs of them come from: files, a video, a camera, the simulated site. One
// interface; the pipeline cannot tell.
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

// Depth pictures come one by one, as `left` with an empty `right`.
struct StereoPair {
  cv::Mat left, right;         // 8 bit grey, the rig's size; depth: 16 bit and empty
  std::uint64_t sequence = 0;  // from 1
  Time sensed_at{};            // when they were taken (middle of the exposures of both)
  double skew = 0;             // right minus left, as their stamps tell [s]
};

// Of live eyes, for people.
struct CameraHealth {
  std::string trouble;                   // empty: nothing
  std::uint64_t taken = 0, dropped = 0;  // pictures or pairs; of pairs those taken too far apart
  double skew = 0;                       // of the last pair used, right minus left [s]
};

template <typename Picture>
class PictureSource {
 public:
  virtual ~PictureSource() = default;
  PictureSource() = default;
  PictureSource(const PictureSource&) = delete;
  PictureSource& operator=(const PictureSource&) = delete;
  // The next picture or pair; blocks until there is one. nullopt: the source has ended or `stop`
  // was requested. Throws std::runtime_error where a source breaks (unreadable file, camera gone, a
  // pair of two sizes); the message names it.
  virtual std::optional<Picture> Next(const std::stop_token& stop) = 0;
  // In words, for people: `files frames/%04d.png (120)`, `files left/*.png (120 pairs)`.
  [[nodiscard]] virtual std::string description() const = 0;
  // nullopt: nothing comes live. Thread-safe.
  [[nodiscard]] virtual std::optional<CameraHealth> health() const { return std::nullopt; }
};
using FrameSource = PictureSource<Frame>;
using StereoSource = PictureSource<StereoPair>;

// Never given an empty picture; throws std::runtime_error where it cannot take one.
using PictureFilter = std::function<cv::Mat(const cv::Mat&)>;

// Opens what the scene names (files, video, device, stream); relative paths are relative to the
// scene file. `paced`: pictures come at the scene's rate; otherwise as fast as they are read, with
// stamps at that rate. `filter`: what the decoding thread makes of each picture, if anything; files
// and videos try it on the first one at once. Throws std::runtime_error: nothing matches,
// unreadable, no such camera, a picture that the filter refuses. Not for kSimulated and kStream.
std::unique_ptr<FrameSource> OpenFrameSource(const Scene& scene, bool paced,
                                             const PictureFilter& filter = {});

// Opens the eyes of sense.camera.stereo or sense.camera.depth: cameras and streams (see
// live_cameras.h), videos, which are paired picture by picture, or files, listed as ListPictures()
// does; the first of each sort of name is paired with the first of the other, and so on. Colour
// becomes grey (ITU-R BT.601); 16-bit pictures are refused, since two eyes scaled differently would
// not match. Depth is one channel of 16 bit. `paced`: pairs come at the scene's rate; otherwise as
// fast as they are read, with stamps at that rate. Throws std::runtime_error: nothing matches, left
// and right are not equally many (how many) or numbered differently, the first pair is unreadable.
// Not for simulated cameras.
std::unique_ptr<StereoSource> OpenStereo(const Scene& scene, bool paced);

}  // namespace palpate
