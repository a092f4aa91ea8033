#include "slave/capture/frame_source.h"

#include <algorithm>
#include <cstddef>
#include <filesystem>
#include <stdexcept>
#include <utility>
#include <vector>

#include <fmt/format.h>
#include <opencv2/core.hpp>
#include <opencv2/imgproc.hpp>

#include "slave/capture/codecs/codecs.h"
#include "slave/capture/live_cameras.h"
#include "slave/capture/picture_files.h"

namespace palpate {
namespace {

namespace fs = std::filesystem;

// A size is part of what a scene says a pixel shows: pictures of another one have other pixels.
void RequireSize(const Camera& camera, const cv::Size& first) {
  const auto [width, height] = camera.size;
  if (width == 0 || (width == first.width && height == first.height)) return;
  throw std::runtime_error("sense.camera.size = [" + std::to_string(width) + ", " +
                           std::to_string(height) + "]: accepted is the size of the images of " +
                           camera.pattern + ", [" + std::to_string(first.width) + ", " +
                           std::to_string(first.height) + "], or no size");
}

// Gives `first`, where there is one, and then what `read` reads, both as `filter` makes them, if
// there is one: it is tried at once, so that pictures it refuses are refused here, not in the loop.
template <typename Read>
DecodeAhead::Decode Decoder(cv::Mat first, Read read, const PictureFilter& filter = {}) {
  if (filter && !first.empty()) static_cast<void>(filter(first));
  return [first = std::move(first), read = std::move(read), filter]() mutable {
    cv::Mat picture = first.empty() ? read() : std::exchange(first, cv::Mat());
    return filter && !picture.empty() ? filter(picture) : picture;
  };
}

std::unique_ptr<FrameSource> OpenFiles(const Camera& camera, bool paced,
                                       const PictureFilter& filter) {
  auto files = ListPictures(camera.pattern, {});
  const auto instants = InstantsOf(files);
  const DecodeAhead::Options options{.description = "files " + camera.pattern + " (" +
                                                    std::to_string(files.size()) +
                                                    MissingInWords(instants) + ")",
                                     .rate = camera.rate,
                                     .instants = instants,
                                     .paced = paced};
  // Read at once: a wrong file is found here, not in the loop.
  cv::Mat first =
      ReadPicture(files.front(), 1, [&](const cv::Size& size) { RequireSize(camera, size); });
  auto read = [files = std::move(files), count = std::size_t{1}]() mutable {
    if (count == files.size()) return cv::Mat();
    ++count;
    return ReadPicture(files[count - 1], count);
  };
  return std::make_unique<DecodeAhead>(Decoder(std::move(first), std::move(read), filter), options);
}

std::unique_ptr<FrameSource> OpenVideo(const Camera& camera, bool paced,
                                       const PictureFilter& filter) {
  const fs::path file = camera.pattern;
  if (!fs::is_regular_file(file)) throw std::runtime_error(file.string() + ": no such video");
  const std::shared_ptr<Film> video = LoadFilms().OpenFile(file.string());
  cv::Mat first = video ? video->Next() : cv::Mat();
  if (first.empty())
    throw std::runtime_error(file.string() + ": not a video, or a video without images");
  RequireSize(camera, first.size());
  const DecodeAhead::Options options{
      .description = "video " + file.string(), .rate = camera.rate, .paced = paced};
  auto read = [video] { return video->Next(); };
  return std::make_unique<DecodeAhead>(Decoder(std::move(first), std::move(read), filter), options);
}

std::unique_ptr<FrameSource> OpenLive(const Camera& camera, const PictureFilter& filter) {
  const bool is_device = camera.source == Camera::Source::kDevice;
  const Eye eye{is_device ? Eye::Kind::kDevice : Eye::Kind::kUrl, camera.device, camera.pattern};
  return FramesOf({InputOf(eye, {camera.size[0], camera.size[1]}, camera.rate)}, filter);
}

[[noreturn]] void Refuse(const fs::path& file, std::size_t number, const std::string& why) {
  throw std::runtime_error(fmt::format("{}: image {}: {}", file.string(), number, why));
}

void RequireRate(double rate) {
  if (rate > 0 && rate < 1e6) return;
  throw std::runtime_error(fmt::format("sense.camera.rate = {:g} Hz: accepted is > 0", rate));
}

// The pictures of one eye, in order, all of one size.
class PictureRow {
 public:
  explicit PictureRow(const std::string& pattern) : files_(ListPictures(pattern, {})) {}

  [[nodiscard]] const std::vector<fs::path>& files() const { return files_; }
  [[nodiscard]] std::size_t count() const { return files_.size(); }
  [[nodiscard]] bool ended() const { return index_ == files_.size(); }
  [[nodiscard]] const fs::path& last_file() const { return files_[index_ - 1]; }
  [[nodiscard]] std::size_t last_number() const { return index_; }

  cv::Mat ReadNext() {
    const fs::path& file = files_[index_++];
    return ReadPicture(file, index_, [this](const cv::Size& size) {
      if (size_.empty()) size_ = size;
      RequireSize(size, size_, "the first one's");
    });
  }
  // Of the picture read last.
  void RequireSize(const cv::Size& is, const cv::Size& accepted, const std::string& whose) const {
    if (is == accepted) return;
    Refuse(last_file(), index_,
           fmt::format("{} x {} px: accepted is {} size, {} x {} px", is.width, is.height, whose,
                       accepted.width, accepted.height));
  }

 private:
  std::vector<fs::path> files_;
  std::size_t index_ = 0;  // pictures read
  cv::Size size_;          // of the first
};

cv::Mat Grey(const cv::Mat& picture, const PictureRow& row) {
  if (picture.depth() != CV_8U) {
    Refuse(row.last_file(), row.last_number(),
           "16 bit: accepted for a pair of cameras is 8 bit, grey or colour");
  }
  if (picture.channels() == 1) return picture;
  cv::Mat grey;
  cv::cvtColor(picture, grey, cv::COLOR_BGR2GRAY);
  return grey;
}

cv::Mat Depth(const cv::Mat& picture, const PictureRow& row) {
  if (picture.type() == CV_16UC1) return picture;
  Refuse(
      row.last_file(), row.last_number(),
      fmt::format("{} channel{} of {} bit: accepted for depth is one channel of 16 bit",
                  picture.channels(), picture.channels() == 1 ? "" : "s", 8 * picture.elemSize1()));
}

// A pair travels through DecodeAhead as one picture, the left above the right.
cv::Mat ReadPair(PictureRow& left, PictureRow& right) {
  if (left.ended()) return {};
  const cv::Mat of_left = Grey(left.ReadNext(), left);
  const cv::Mat of_right = Grey(right.ReadNext(), right);
  right.RequireSize(of_right.size(), of_left.size(), "the left image's");
  cv::Mat both;
  cv::vconcat(of_left, of_right, both);
  return both;
}

cv::Mat ReadDepth(PictureRow& row) {
  return row.ended() ? cv::Mat() : Depth(row.ReadNext(), row);
}

// Where the first two bear the same number, all must: a picture missing on the left and another one
// on the right would pair what does not belong together.
void RequireSameNumbers(const PictureRow& left, const PictureRow& right) {
  if (LastNumber(left.files().front()) != LastNumber(right.files().front())) return;
  for (std::size_t k = 0; k < left.count(); ++k) {
    const fs::path &a = left.files()[k], &b = right.files()[k];
    if (LastNumber(a) == LastNumber(b)) continue;
    throw std::runtime_error(
        fmt::format("sense.camera.stereo: pair {} would be {} and {}: accepted are images whose "
                    "numbers differ as in the first pair",
                    k + 1, a.string(), b.string()));
  }
}

class StereoFiles final : public StereoSource {
 public:
  StereoFiles(DecodeAhead::Decode decode, DecodeAhead::Options options, bool pairs)
      : ahead_(std::move(decode), std::move(options)), pairs_(pairs) {}

  std::optional<StereoPair> Next(const std::stop_token& stop) override {
    auto frame = ahead_.Next(stop);
    if (!frame) return std::nullopt;
    const int height = pairs_ ? frame->image.rows / 2 : frame->image.rows;
    StereoPair pair;
    pair.left = frame->image.rowRange(0, height);
    if (pairs_) pair.right = frame->image.rowRange(height, 2 * height);
    pair.sequence = frame->sequence;
    pair.sensed_at = frame->sensed_at;
    return pair;
  }
  [[nodiscard]] std::string description() const override { return ahead_.description(); }

 private:
  DecodeAhead ahead_;
  bool pairs_;
};

// `read` gives one picture after the other; the first is read at once, so that a wrong file is
// found here and not in the loop.
template <typename Read>
std::unique_ptr<StereoSource> Open(Read read, const DecodeAhead::Options& options, bool pairs) {
  cv::Mat first = read();
  return std::make_unique<StereoFiles>(Decoder(std::move(first), std::move(read)), options, pairs);
}

// The pictures of films in step, which are paired by their number: they travel one above the other.
std::unique_ptr<StereoSource> OpenFilms(const std::vector<Eye>& eyes, PairLayout layout,
                                        double rate, bool paced) {
  std::vector<std::shared_ptr<Film>> films;
  std::string names;
  for (const Eye& eye : eyes) {
    films.push_back(LoadFilms().OpenFile(eye.address));
    if (!films.back()) throw std::runtime_error(eye.address + ": not a video");
    names += (names.empty() ? "" : " | ") + eye.address;
  }
  const auto read = [films, layout, names] {
    std::vector<cv::Mat> pictures;
    for (const auto& film : films) {
      pictures.push_back(film->Next());
      if (pictures.back().empty()) return cv::Mat();
    }
    const StereoPair pair = PairFrom(pictures, layout, names);
    cv::Mat both;
    cv::vconcat(pair.left, pair.right, both);
    return both;
  };
  const DecodeAhead::Options options{.description = "video " + names, .rate = rate, .paced = paced};
  return Open(read, options, true);
}

// `size`: of each camera's pictures; empty: its own.
std::unique_ptr<StereoSource> OpenCameras(const std::vector<Eye>& eyes, PairLayout layout,
                                          const cv::Size& size, double rate, double sync,
                                          bool paced) {
  RequireRate(rate);
  const auto is_film = [](const Eye& eye) { return eye.kind == Eye::Kind::kVideo; };
  if (std::ranges::all_of(eyes, is_film)) return OpenFilms(eyes, layout, rate, paced);
  std::vector<CameraInput> inputs;
  for (const Eye& eye : eyes) inputs.push_back(InputOf(eye, size, rate));
  return PairsOf(std::move(inputs), layout, sync);
}

std::unique_ptr<StereoSource> OpenPairs(const StereoCameras& cameras, bool paced) {
  RequireRate(cameras.rate);
  PictureRow left(cameras.left), right(cameras.right);
  if (left.count() != right.count()) {
    throw std::runtime_error(
        fmt::format("sense.camera.stereo: left = {} has {} images, right = {} has {}: accepted is "
                    "the same count of both",
                    cameras.left, left.count(), cameras.right, right.count()));
  }
  RequireSameNumbers(left, right);
  const DecodeAhead::Options options{
      .description = fmt::format("files {} | {} ({} pairs{})", cameras.left, cameras.right,
                                 left.count(), MissingInWords(InstantsOf(left.files()))),
      .rate = cameras.rate,
      .instants = InstantsOf(left.files()),
      .paced = paced};
  return Open([left = std::move(left),
               right = std::move(right)]() mutable { return ReadPair(left, right); },
              options, true);
}

std::unique_ptr<StereoSource> OpenDepth(const DepthPictures& depth, bool paced) {
  RequireRate(depth.rate);
  PictureRow row(depth.pattern);
  const DecodeAhead::Options options{
      .description = fmt::format("files {} ({} depth images{})", depth.pattern, row.count(),
                                 MissingInWords(InstantsOf(row.files()))),
      .rate = depth.rate,
      .instants = InstantsOf(row.files()),
      .paced = paced};
  return Open([row = std::move(row)]() mutable { return ReadDepth(row); }, options, false);
}

}  // namespace

std::unique_ptr<FrameSource> OpenFrameSource(const Scene& scene, bool paced,
                                             const PictureFilter& filter) {
  if (!scene.sense.Find<Camera>())
    throw std::runtime_error(scene.name + ": the scene has no camera");
  const Camera& camera = *scene.sense.Find<Camera>();
  if (!(camera.rate > 0)) {
    throw std::runtime_error("sense.camera.rate = " + std::to_string(camera.rate) +
                             " Hz: accepted is > 0");
  }
  switch (camera.source) {
    case Camera::Source::kFiles:
      return OpenFiles(camera, paced, filter);
    case Camera::Source::kVideo:
      return OpenVideo(camera, paced, filter);
    case Camera::Source::kDevice:
    case Camera::Source::kUrl:
      return OpenLive(camera, filter);
    case Camera::Source::kStream:
    case Camera::Source::kSimulated:
      break;
  }
  throw std::runtime_error(scene.name + ": a simulated camera is opened by the simulator");
}

std::unique_ptr<StereoSource> OpenStereo(const Scene& scene, bool paced) {
  if (TakesPictures(scene.sense)) {
    throw std::runtime_error(scene.name + ": images of a stream arrive only from a driver");
  }
  if (const auto* depth = scene.sense.Find<DepthPictures>()) {
    if (depth->source != DepthPictures::Source::kEye) return OpenDepth(*depth, paced);
    if (depth->eye.kind == Eye::Kind::kOpenNi) {
      RequireRate(depth->rate);
      return PairsOf({InputOf(depth->eye, {}, depth->rate, depth->unit)}, PairLayout::kDepth, 0);
    }
    return OpenCameras({depth->eye}, PairLayout::kDepth, {}, depth->rate, 0, paced);
  }
  const auto* stereo = scene.sense.Find<StereoCameras>();
  if (stereo == nullptr) {
    throw std::runtime_error(scene.name + ": the scene has no pair of cameras");
  }
  if (stereo->source == StereoCameras::Source::kSimulated) {
    throw std::runtime_error(scene.name + ": a simulated pair is opened by the simulator");
  }
  if (stereo->source != StereoCameras::Source::kEyes) return OpenPairs(*stereo, paced);
  const bool is_one = stereo->eyes.size() == 1;
  const auto [width, height] = stereo->size;  // the rig's
  return OpenCameras(stereo->eyes, is_one ? PairLayout::kSideBySide : PairLayout::kTwoCameras,
                     {is_one ? 2 * width : width, height}, stereo->rate, stereo->sync, paced);
}

}  // namespace palpate
