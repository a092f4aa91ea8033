#include "slave/capture/frame_source.h"

#include <algorithm>
#include <cstddef>
#include <exception>
#include <filesystem>
#include <stdexcept>
#include <thread>
#include <utility>
#include <vector>

#include <fmt/format.h>
#include <opencv2/core.hpp>

#include "slave/capture/codecs/codecs.h"
#include "slave/capture/image_files.h"
#include "slave/capture/image_queue.h"
#include "slave/capture/live_cameras.h"
#include "slave/capture/pair_images.h"

namespace palpate {
namespace {

namespace fs = std::filesystem;

// The size belongs to the scene's pixel size: images of another size have other pixels.
void RequireSize(const Camera& camera, const cv::Size& first) {
  const auto [width, height] = camera.size;
  if (width == 0 || (width == first.width && height == first.height)) return;
  throw std::runtime_error("sense.camera.size = [" + std::to_string(width) + ", " +
                           std::to_string(height) + "]: expected the size of the images of " +
                           camera.pattern + ", [" + std::to_string(first.width) + ", " +
                           std::to_string(first.height) + "], or no size");
}

// Returns the next images without number and timestamp. Empty images end the source.
using ReadImages = std::function<StereoPair()>;

struct ReadOptions {
  std::string description;
  double rate = 60;  // timestamps are 1 / rate apart [Hz], > 0
  // Times of the images after the first image, in multiples of 1 / rate. Empty: no gaps.
  std::vector<std::uint64_t> instants = {};
};

// Decodes recorded images in a separate thread, a few ahead of the reader, and assigns timestamps.
// The first images are read at once, so that invalid ones are reported here.
class DecodeAhead final : public StereoSource {
 public:
  DecodeAhead(ReadImages read, ReadOptions options)
      : read_(std::move(read)),
        options_(std::move(options)),
        first_(read_()),
        start_(Clock::now()),
        thread_([this](const std::stop_token& stop) { Run(stop); }) {}

  std::optional<StereoPair> Next(const std::stop_token& stop) override {
    auto images = queue_.Take(stop);
    if (images) queue_.WaitUntil(images->sensed_at, stop);
    if (stop.stop_requested()) return std::nullopt;
    return images;
  }
  [[nodiscard]] std::string description() const override { return options_.description; }

 private:
  void Run(const std::stop_token& stop) {
    constexpr std::size_t kAhead = 4;  // images: at 60 Hz a disk may be late by 67 ms
    std::exception_ptr failure;
    try {
      StereoPair images = std::move(first_);
      for (std::uint64_t k = 0; !images.left.empty(); ++k) {
        images.sequence = k + 1;
        const std::uint64_t instant = k < options_.instants.size() ? options_.instants[k] : k;
        images.sensed_at = start_ + Seconds(static_cast<double>(instant) / options_.rate);
        if (!queue_.Push(std::move(images), kAhead, stop)) break;
        images = read_();
      }
    } catch (...) {
      failure = std::current_exception();
    }
    queue_.Close(failure);
  }

  ReadImages read_;
  ReadOptions options_;
  StereoPair first_;
  Time start_;
  ImageQueue queue_;
  std::jthread thread_;  // last member: it stops and joins before the others are destroyed
};

// Returns the images of `read`. The decoding thread applies `filter` if there is one.
std::unique_ptr<FrameSource> OpenRecorded(std::function<cv::Mat()> read, ImageFilter filter,
                                          ReadOptions options) {
  auto filtered = [read = std::move(read), filter = std::move(filter)] {
    const cv::Mat image = read();
    return StereoPair{.left = filter && !image.empty() ? filter(image) : image};
  };
  return LeftImages(std::make_unique<DecodeAhead>(std::move(filtered), std::move(options)));
}

// The image files of one camera, in order, all of one size.
class ImageFiles {
 public:
  explicit ImageFiles(std::vector<fs::path> files) : files_(std::move(files)) {}

  [[nodiscard]] const std::vector<fs::path>& files() const { return files_; }
  [[nodiscard]] std::size_t count() const { return files_.size(); }
  [[nodiscard]] bool ended() const { return index_ == files_.size(); }
  [[nodiscard]] std::string next_file() const { return files_[index_].string(); }
  [[nodiscard]] std::size_t next_number() const { return index_ + 1; }

  // `accept`: see ReadImage, before the comparison with the first.
  cv::Mat ReadNext(const AcceptSize& accept = {}) {
    const fs::path& file = files_[index_++];
    return ReadImage(file, index_, [&](const cv::Size& size) {
      if (accept) accept(size);
      if (size_.empty()) size_ = size;
      if (size == size_) return;
      throw std::runtime_error(
          fmt::format("{}: image {}: {} x {} px: expected the first one's size, {} x {} px",
                      file.string(), index_, size.width, size.height, size_.width, size_.height));
    });
  }

 private:
  std::vector<fs::path> files_;
  std::size_t index_ = 0;  // images read
  cv::Size size_;          // of the first
};

std::unique_ptr<FrameSource> OpenFiles(const Camera& camera, const ImageFilter& filter) {
  auto files = ListImages(camera.pattern, {});
  const auto instants = InstantsOf(files);
  ReadOptions options{.description = fmt::format("files {} ({}{})", camera.pattern, files.size(),
                                                 MissingInWords(instants)),
                      .rate = camera.rate,
                      .instants = instants};
  auto read = [camera, files = ImageFiles(std::move(files))]() mutable {
    if (files.ended()) return cv::Mat();
    const bool is_first = files.next_number() == 1;
    return files.ReadNext([&](const cv::Size& size) {
      if (is_first) RequireSize(camera, size);
    });
  };
  return OpenRecorded(std::move(read), filter, std::move(options));
}

std::unique_ptr<FrameSource> OpenVideo(const Camera& camera, const ImageFilter& filter) {
  const fs::path file = camera.pattern;
  if (!fs::is_regular_file(file)) throw std::runtime_error(file.string() + ": no such video");
  const std::shared_ptr<VideoStream> video = LoadVideoBackend().OpenFile(file.string());
  cv::Mat first = video ? video->Next() : cv::Mat();
  if (first.empty())
    throw std::runtime_error(file.string() + ": not a video, or a video without images");
  RequireSize(camera, first.size());
  auto read = [video, first]() mutable {
    return first.empty() ? video->Next() : std::exchange(first, cv::Mat());
  };
  return OpenRecorded(std::move(read), filter,
                      {.description = "video " + file.string(), .rate = camera.rate});
}

std::unique_ptr<FrameSource> OpenLive(const Camera& camera, const ImageFilter& filter) {
  const bool is_device = camera.source == Camera::Source::kDevice;
  const Eye eye{is_device ? Eye::Kind::kDevice : Eye::Kind::kUrl, camera.device, camera.pattern};
  return FramesOf({InputOf(eye, {camera.size[0], camera.size[1]}, camera.rate)}, filter);
}

void RequireRate(double rate) {
  if (rate > 0 && rate < 1e6) return;
  throw std::runtime_error(fmt::format("sense.camera.rate = {:g} Hz: expected > 0", rate));
}

StereoPair ReadPair(ImageFiles& left, ImageFiles& right) {
  if (left.ended()) return {};
  const std::string name =
      fmt::format("{} | {}: image {}", left.next_file(), right.next_file(), left.next_number());
  StereoPair images;
  images.left = left.ReadNext();
  images.right = right.ReadNext();
  return Arranged(std::move(images), PairLayout::kTwoCameras, name);
}

StereoPair ReadDepth(ImageFiles& files) {
  if (files.ended()) return {};
  const std::string name = fmt::format("{}: image {}", files.next_file(), files.next_number());
  return Arranged({.left = files.ReadNext()}, PairLayout::kDepth, name);
}

// If the first two files have the same number, all pairs must. Otherwise a missing image on the
// left and another one on the right would cause wrong pairs.
void RequireSameNumbers(const ImageFiles& left, const ImageFiles& right) {
  if (LastNumber(left.files().front()) != LastNumber(right.files().front())) return;
  for (std::size_t k = 0; k < left.count(); ++k) {
    const fs::path &a = left.files()[k], &b = right.files()[k];
    if (LastNumber(a) == LastNumber(b)) continue;
    throw std::runtime_error(
        fmt::format("sense.camera.stereo: pair {} would be {} and {}: expected images whose "
                    "numbers differ as in the first pair",
                    k + 1, a.string(), b.string()));
  }
}

// Returns the images of two videos, paired by their number.
std::unique_ptr<StereoSource> OpenVideos(const std::vector<Eye>& cameras, PairLayout layout,
                                         double rate) {
  std::vector<std::shared_ptr<VideoStream>> videos;
  std::string names;
  for (const Eye& eye : cameras) {
    videos.push_back(LoadVideoBackend().OpenFile(eye.address));
    if (!videos.back()) throw std::runtime_error(eye.address + ": not a video");
    names += (names.empty() ? "" : " | ") + eye.address;
  }
  const auto read = [videos, layout, names]() -> StereoPair {
    StereoPair images;
    images.left = videos.front()->Next();
    if (videos.size() > 1) images.right = videos.back()->Next();
    const bool ended = images.left.empty() || (videos.size() > 1 && images.right.empty());
    return ended ? StereoPair() : Arranged(std::move(images), layout, names);
  };
  return std::make_unique<DecodeAhead>(read,
                                       ReadOptions{.description = "video " + names, .rate = rate});
}

// `size`: of each camera's images; empty: its own.
std::unique_ptr<StereoSource> OpenCameras(const std::vector<Eye>& cameras, PairLayout layout,
                                          const cv::Size& size, double rate, double sync) {
  RequireRate(rate);
  const auto is_video = [](const Eye& eye) { return eye.kind == Eye::Kind::kVideo; };
  if (std::ranges::all_of(cameras, is_video)) return OpenVideos(cameras, layout, rate);
  std::vector<CameraInput> inputs;
  for (const Eye& eye : cameras) inputs.push_back(InputOf(eye, size, rate));
  return PairsOf(std::move(inputs), layout, sync);
}

std::unique_ptr<StereoSource> OpenPairs(const StereoCameras& cameras) {
  RequireRate(cameras.rate);
  ImageFiles left(ListImages(cameras.left, {})), right(ListImages(cameras.right, {}));
  if (left.count() != right.count()) {
    throw std::runtime_error(
        fmt::format("sense.camera.stereo: left = {} has {} images, right = {} has {}: expected "
                    "the same count of both",
                    cameras.left, left.count(), cameras.right, right.count()));
  }
  RequireSameNumbers(left, right);
  const auto instants = InstantsOf(left.files());
  ReadOptions options{
      .description = fmt::format("files {} | {} ({} pairs{})", cameras.left, cameras.right,
                                 left.count(), MissingInWords(instants)),
      .rate = cameras.rate,
      .instants = instants};
  auto read = [left = std::move(left), right = std::move(right)]() mutable {
    return ReadPair(left, right);
  };
  return std::make_unique<DecodeAhead>(std::move(read), std::move(options));
}

std::unique_ptr<StereoSource> OpenDepth(const DepthImages& depth) {
  RequireRate(depth.rate);
  ImageFiles files(ListImages(depth.pattern, {}));
  const auto instants = InstantsOf(files.files());
  ReadOptions options{.description = fmt::format("files {} ({} depth images{})", depth.pattern,
                                                 files.count(), MissingInWords(instants)),
                      .rate = depth.rate,
                      .instants = instants};
  return std::make_unique<DecodeAhead>(
      [files = std::move(files)]() mutable { return ReadDepth(files); }, std::move(options));
}

}  // namespace

std::unique_ptr<FrameSource> OpenFrameSource(const Scene& scene, const ImageFilter& filter) {
  if (!scene.sense.Find<Camera>())
    throw std::runtime_error(scene.name + ": the scene has no camera");
  return OpenCamera(*scene.sense.Find<Camera>(), filter);
}

std::unique_ptr<FrameSource> OpenCamera(const Camera& camera, const ImageFilter& filter) {
  if (!(camera.rate > 0)) {
    throw std::runtime_error("sense.camera.rate = " + std::to_string(camera.rate) +
                             " Hz: expected > 0");
  }
  switch (camera.source) {
    case Camera::Source::kFiles:
      return OpenFiles(camera, filter);
    case Camera::Source::kVideo:
      return OpenVideo(camera, filter);
    case Camera::Source::kDevice:
    case Camera::Source::kUrl:
      return OpenLive(camera, filter);
    case Camera::Source::kStream:
    case Camera::Source::kSimulated:
      break;
  }
  throw std::runtime_error("a simulated camera is opened by the simulator");
}

std::unique_ptr<StereoSource> OpenStereo(const Scene& scene) {
  if (TakesImages(scene.sense)) {
    throw std::runtime_error(scene.name + ": images of a stream arrive only from a driver");
  }
  if (const auto* depth = scene.sense.Find<DepthImages>()) {
    if (depth->source != DepthImages::Source::kEye) return OpenDepth(*depth);
    return OpenCameras({depth->eye}, PairLayout::kDepth, {}, depth->rate, 0);
  }
  const auto* stereo = scene.sense.Find<StereoCameras>();
  if (stereo == nullptr) {
    throw std::runtime_error(scene.name + ": the scene has no pair of cameras");
  }
  if (stereo->source == StereoCameras::Source::kSimulated) {
    throw std::runtime_error(scene.name + ": a simulated pair is opened by the simulator");
  }
  if (stereo->source != StereoCameras::Source::kCameras) return OpenPairs(*stereo);
  const bool is_one = stereo->cameras.size() == 1;
  const auto [width, height] = stereo->size;  // the rig's
  return OpenCameras(stereo->cameras, is_one ? PairLayout::kSideBySide : PairLayout::kTwoCameras,
                     {is_one ? 2 * width : width, height}, stereo->rate, stereo->sync);
}

}  // namespace palpate
