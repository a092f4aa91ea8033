// Cameras and streams that OpenCV reads, one thread each: the newest image counts, two
// free-running cameras are paired by the arrival times of their images, and an unplugged camera
// reconnects on its own.
#pragma once

#include <chrono>
#include <functional>
#include <memory>
#include <optional>
#include <stop_token>
#include <string>
#include <thread>
#include <vector>

#include "slave/capture/codecs/codecs.h"
#include "slave/capture/frame_source.h"
#include "slave/capture/pair_images.h"

namespace palpate {

// Source of one camera's images. Tests replace it by their own camera.
struct CameraInput {
  std::string name;                                    // for people: `camera 0`
  std::function<std::unique_ptr<VideoStream>()> open;  // null: it is not there (now)
  cv::Size size{};  // size of its images [px]; empty: that of the first image
};
// Inputs of the scene's cameras. `unit`: depth of a count [m]; a camera that reports another unit
// is rejected when it is opened. Throws std::runtime_error if the module that reads it is not
// installed.
CameraInput InputOf(const Eye& eye, const cv::Size& size, double rate);

// Thread-safe. The timestamp is the slave's clock at the arrival of an image, for a pair the mean
// of both. It is later than the exposure by transfer and exposure time, and a rolling shutter
// captures its lines at different times.
class LiveCameras final : public StereoSource {
 public:
  // Opens one camera, or two at the same time. `sync`: images of two cameras that arrive farther
  // apart are not a pair [s]. `timeout`: longest time for opening one, and for the first image or
  // pair. Throws std::runtime_error: one is missing, or does not answer.
  LiveCameras(std::vector<CameraInput> inputs, PairLayout layout, double sync,
              std::chrono::milliseconds timeout = std::chrono::seconds(10));
  ~LiveCameras() override;

  // Waits for the newest image that was not yet returned. nullopt: `stop`. Throws
  // std::runtime_error before the first one only: none arrives in time, or its size is not the
  // scene's. Later images with another format are dropped and reported as trouble.
  std::optional<StereoPair> Next(const std::stop_token& stop) override;
  [[nodiscard]] std::optional<CameraHealth> health() const override;
  [[nodiscard]] std::string description() const override;

 private:
  struct State;
  void End();  // threads that do not return are abandoned

  std::shared_ptr<State> state_;       // shared with the threads, which may outlive this object
  std::vector<std::jthread> threads_;  // one per camera
  PairLayout layout_;
};

std::unique_ptr<FrameSource> FramesOf(std::vector<CameraInput> inputs, ImageFilter filter);
std::unique_ptr<StereoSource> PairsOf(std::vector<CameraInput> inputs, PairLayout layout,
                                      double sync);

}  // namespace palpate
