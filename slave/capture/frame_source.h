// Sources of images and stereo pairs: files, a video, a camera, the simulator. The pipeline uses
// one interface for all.
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
  Time sensed_at{};            // time of capture (middle of the exposure)
};

// Depth images come one by one, as `left` with an empty `right`.
struct StereoPair {
  cv::Mat left, right;         // 8 bit grey, the rig's size; depth: 16 bit and empty
  std::uint64_t sequence = 0;  // from 1
  Time sensed_at{};            // time of capture (middle of the exposures of both)
  double skew = 0;             // time between right and left by their timestamps [s]
};

// Status of live cameras, for people.
struct CameraHealth {
  std::string trouble;  // empty: nothing
  std::uint64_t taken = 0,
                dropped = 0;  // images or pairs; for pairs, those whose images are too far apart
  double skew = 0;            // time difference of the last used pair, right minus left [s]
};

template <typename Image>
class ImageSource {
 public:
  virtual ~ImageSource() = default;
  ImageSource() = default;
  ImageSource(const ImageSource&) = delete;
  ImageSource& operator=(const ImageSource&) = delete;
  // The next image or pair; blocks until there is one. nullopt: the source has ended or `stop` was
  // requested. Throws std::runtime_error on an error of the source (unreadable file, camera gone, a
  // pair of two sizes); the message names it.
  virtual std::optional<Image> Next(const std::stop_token& stop) = 0;
  // Returns a description for display, such as `files frames/%04d.png (120)` or `files left/*.png
  // (120 pairs)`.
  [[nodiscard]] virtual std::string description() const = 0;
  // nullopt: not a live source. Thread-safe.
  [[nodiscard]] virtual std::optional<CameraHealth> health() const { return std::nullopt; }
};
using FrameSource = ImageSource<Frame>;
using StereoSource = ImageSource<StereoPair>;

// Never called with an empty image; throws std::runtime_error if it cannot use one.
using ImageFilter = std::function<cv::Mat(const cv::Mat&)>;
// Opens the images of one camera.
using FrameOpener = std::function<std::unique_ptr<FrameSource>(const ImageFilter& filter)>;

// Opens the source of the scene (files, video, device, stream); relative paths are relative to the
// scene file. Images of files and videos come at the scene's rate by the Clock of the thread that
// takes them. `filter`: optional processing of each image in the decoding thread; files and videos
// test it on the first image at once. Throws std::runtime_error: nothing matches, unreadable, no
// such camera, an image that the filter rejects. Not for kSimulated and kStream.
std::unique_ptr<FrameSource> OpenFrameSource(const Scene& scene, const ImageFilter& filter = {});
// Opens the source of one camera.
std::unique_ptr<FrameSource> OpenCamera(const Camera& camera, const ImageFilter& filter = {});

// Opens the cameras of sense.camera.stereo or sense.camera.depth: live cameras and streams (see
// live_cameras.h), videos, which are paired image by image, or files, listed as by ListImages();
// the first left file is paired with the first right file, and so on. Colour is converted to grey
// (ITU-R BT.601). 16-bit images are rejected, because two differently scaled cameras would not
// match. Depth has one channel of 16 bit. Pairs of files and videos are returned at the scene's
// rate, as single images are. Throws std::runtime_error: nothing matches, different counts or
// numbers of left and right, the first pair is unreadable. Not for simulated cameras.
std::unique_ptr<StereoSource> OpenStereo(const Scene& scene);

}  // namespace palpate
