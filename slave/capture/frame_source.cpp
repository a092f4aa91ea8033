#include "slave/capture/frame_source.h"

#include <filesystem>
#include <memory>
#include <stdexcept>
#include <utility>
#include <vector>

#include "slave/capture/codecs/films.h"
#include "slave/capture/decode_ahead.h"
#include "slave/capture/picture_files.h"

namespace palpate {
namespace {

namespace fs = std::filesystem;

// A size is part of what a scene says a pixel shows: pictures of another one have other pixels.
void RequireSize(const Camera& camera, const cv::Size& first) {
  const auto [width, height] = camera.size;
  if (width == 0 || (width == first.width && height == first.height)) return;
  throw std::runtime_error("sense.camera.size = [" + std::to_string(width) + ", " +
                           std::to_string(height) + "]: accepted is that of the pictures of " +
                           camera.pattern + ", [" + std::to_string(first.width) + ", " +
                           std::to_string(first.height) + "], or no size");
}

// `first`: tried at once, so that pictures the filter refuses are refused here, not in the loop.
DecodeAhead::Decode Filtered(const PictureFilter& filter, const cv::Mat& first,
                             DecodeAhead::Decode next) {
  if (!filter) return next;
  if (!first.empty()) static_cast<void>(filter(first));
  return [filter, next = std::move(next)] {
    cv::Mat picture = next();
    return picture.empty() ? picture : filter(picture);
  };
}

std::unique_ptr<FrameSource> OpenFiles(const Camera& camera, bool paced,
                                       const PictureFilter& filter) {
  auto files = ListPictures(camera.pattern, {});
  DecodeAhead::Options options;
  options.description = "files " + camera.pattern + " (" + std::to_string(files.size()) + ")";
  options.rate = camera.rate;
  options.paced = paced;
  // Read at once: a wrong file is found here, not in the loop.
  cv::Mat first =
      ReadPicture(files.front(), 1, [&](const cv::Size& size) { RequireSize(camera, size); });
  auto next = [files = std::move(files), first, index = std::size_t{0}]() mutable {
    if (index == files.size()) return cv::Mat();
    ++index;
    return index == 1 ? std::exchange(first, cv::Mat()) : ReadPicture(files[index - 1], index);
  };
  return std::make_unique<DecodeAhead>(Filtered(filter, first, std::move(next)),
                                       std::move(options));
}

std::unique_ptr<FrameSource> OpenVideo(const Camera& camera, bool paced,
                                       const PictureFilter& filter) {
  const fs::path file = camera.pattern;
  if (!fs::is_regular_file(file)) throw std::runtime_error(file.string() + ": no such video");
  const std::shared_ptr<Film> video = LoadFilms().OpenFile(file.string());
  cv::Mat first = video ? video->Next() : cv::Mat();
  if (first.empty()) throw std::runtime_error(file.string() + ": not a video, or without pictures");
  RequireSize(camera, first.size());
  DecodeAhead::Options options;
  options.description = "video " + file.string();
  options.rate = camera.rate;
  options.paced = paced;
  auto next = [video, first]() mutable {
    return first.empty() ? video->Next() : std::exchange(first, cv::Mat());
  };
  return std::make_unique<DecodeAhead>(Filtered(filter, first, std::move(next)),
                                       std::move(options));
}

std::unique_ptr<FrameSource> OpenDevice(const Camera& camera, const PictureFilter& filter) {
  const std::string name = "camera " + std::to_string(camera.device);
  const std::shared_ptr<Film> device =
      LoadFilms().OpenDevice(camera.device, {camera.size[0], camera.size[1]}, camera.rate);
  if (!device) {
    throw std::runtime_error(name + ": no such camera, or not permitted (/dev/video" +
                             std::to_string(camera.device) + ")");
  }
  DecodeAhead::Options options;
  options.description = name;
  options.rate = camera.rate;
  options.live = true;
  auto next = [device, name] {
    cv::Mat image = device->Next();
    if (image.empty()) throw std::runtime_error(name + ": gone");
    return image;
  };
  return std::make_unique<DecodeAhead>(Filtered(filter, {}, std::move(next)), std::move(options));
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
      return OpenDevice(camera, filter);
    case Camera::Source::kSimulated:
      break;
  }
  throw std::runtime_error(scene.name + ": a simulated camera is opened by the simulated site");
}

}  // namespace palpate
