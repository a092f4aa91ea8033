// The camera of a set-up: several readers use its images at the same time, and recorded images
// repeat.
#pragma once

#include <memory>
#include <optional>
#include <stop_token>
#include <string>

#include "slave/capture/frame_source.h"

namespace palpate {

// Thread-safe.
class SharedCamera {
 public:
  // Opens a live camera. Throws the exceptions of OpenFrameSource.
  explicit SharedCamera(const Camera& camera);
  ~SharedCamera();
  SharedCamera(const SharedCamera&) = delete;
  SharedCamera& operator=(const SharedCamera&) = delete;

  // Returns a separate source for one reader. This object must outlive it. Live: from `first` on,
  // if it is given, else from the newest image on. Recorded: from the first image on, repeatedly.
  [[nodiscard]] std::unique_ptr<FrameSource> Open(const ImageFilter& filter = {},
                                                  std::optional<Frame> first = {}) const;
  // Live: the next image, which was taken after this call. Recorded: the first one. nullopt: `stop`
  // was requested. Throws std::runtime_error if none arrives within 2 s plus two periods.
  [[nodiscard]] std::optional<Frame> Fresh(const std::stop_token& stop) const;

  // Returns the camera with the size of its images.
  [[nodiscard]] const Camera& camera() const { return camera_; }
  // The keys of `sense.camera` that open it, one a line.
  [[nodiscard]] std::string SceneLines() const;
  // Returns whether `other` opens the same images.
  [[nodiscard]] bool IsOpenedBy(const Camera& other) const;

 private:
  class Live;
  class LiveFrames;
  Camera camera_;
  std::shared_ptr<Live> live_;  // null: recorded
};

// The camera that a command line names: a number (/dev/video0), an address or a GStreamer pipeline,
// otherwise image files or a video.
Camera NamedCamera(const std::string& name, double rate);

}  // namespace palpate
