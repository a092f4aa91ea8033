// Cameras and streams that OpenCV or OpenNI2 reads, one thread each: the newest picture wins, two
// that run freely are paired by the time at which their pictures came, and one that is unplugged
// comes back by itself.
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

namespace palpate {

// Where one eye's pictures come from. The seam at which tests put a camera of their own.
struct CameraInput {
  std::string name;                             // for people: `camera 0`
  std::function<std::unique_ptr<Film>()> open;  // null: it is not there (now)
  cv::Size size{};                              // of its pictures [px]; empty: the first one's
};
// Of what the scene names. `unit` of a count of depth [m]: a camera that tells another one is
// refused where it is opened. Throws std::runtime_error where the module that reads it is not
// there.
CameraInput InputOf(const Eye& eye, const cv::Size& size, double rate, double unit = 0);

// Thread-safe. Stamps are the slave's clock when a picture has come: exposure and transfer lie
// before it, and the lines of a rolling shutter are taken at different times.
class LiveCameras {
 public:
  struct Shot {
    std::vector<cv::Mat> pictures;  // one per eye
    std::uint64_t sequence = 0;     // from 1
    Time sensed_at{};               // in the middle of the two eyes'
    double skew = 0;                // right minus left [s]
  };

  // One or two. `sync`: pictures of two eyes that came farther apart are no pair [s]. Opens them at
  // once. `patience`: how long opening one, and the first picture or pair, may take. Throws
  // std::runtime_error: one is not there, or does not answer.
  LiveCameras(std::vector<CameraInput> inputs, double sync,
              std::chrono::milliseconds patience = std::chrono::seconds(10));
  ~LiveCameras();
  LiveCameras(const LiveCameras&) = delete;
  LiveCameras& operator=(const LiveCameras&) = delete;

  // The newest that nobody has taken; waits for it. nullopt: `stop`. Throws std::runtime_error
  // before the first one only: none comes in time, or what comes is not of the eye's size.
  // Later ones that are unlike the first are left out, and told as trouble.
  std::optional<Shot> Next(const std::stop_token& stop);
  [[nodiscard]] CameraHealth health() const;
  [[nodiscard]] std::string description() const;

 private:
  struct State;
  void End();  // threads that do not come back are left to themselves

  std::shared_ptr<State> state_;       // its threads', too, as long as they live
  std::vector<std::jthread> threads_;  // one per eye
};

enum class PairLayout : std::uint8_t { kTwoCameras, kSideBySide, kDepth };
// The pair that `pictures` are, without number and stamp. Throws std::runtime_error that begins
// with `name`: another type than a pair or depth takes, two sizes.
StereoPair PairFrom(const std::vector<cv::Mat>& pictures, PairLayout layout,
                    const std::string& name);

std::unique_ptr<FrameSource> FramesOf(std::vector<CameraInput> inputs, PictureFilter filter);
std::unique_ptr<StereoSource> PairsOf(std::vector<CameraInput> inputs, PairLayout layout,
                                      double sync);

}  // namespace palpate
