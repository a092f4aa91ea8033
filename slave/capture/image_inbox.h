// Receives images from drivers (FeedImages): the newest counts, and images that do not fit the
// scene are rejected with a sentence.
#pragma once

#include <cstdint>
#include <memory>
#include <optional>
#include <stop_token>
#include <string>

#include "shared/state/clock.h"
#include "slave/capture/frame_source.h"

namespace palpate {

// An image as received.
struct PushedImage {
  enum class Encoding : std::uint8_t {
    kJpeg,
    kPng,
    kGrey8,
    kBgr8,
    kGrey16
  } encoding = Encoding::kJpeg;
  const std::string* data = nullptr;  // outlives the call
  unsigned width = 0, height = 0;     // size [px]; for files 0: the size in the file
};

// The images of one instant, as received. Sender's clock.
struct PushedSample {
  std::uint64_t sequence = 0;  // 0: not used
  Time sensed_at{};
  PushedImage image;
  std::optional<PushedImage> right;
  std::optional<Time> right_sensed_at;
  double delay = 0;  // from the capture to the sending, as the driver knows it [s]
};

// Thread-safe. Contains one sample.
class ImageInbox {
 public:
  using SenderId = std::uint64_t;  // never 0

  // Makes the inbox of the scene's camera, pair or depth images, whose source is a stream.
  explicit ImageInbox(const Scene& scene);
  ~ImageInbox();
  ImageInbox(const ImageInbox&) = delete;
  ImageInbox& operator=(const ImageInbox&) = delete;

  struct Refusal {
    std::string why;
    bool is_held = false;  // refused only because another sender holds the inbox
  };
  // Decodes and stores a sample that arrived at `arrived_at`. Rejects: undecodable data; another
  // size, kind or number of channels than the scene's or the first one's; a sequence that does not
  // rise, a time that does not increase; far more samples than the scene's rate; another `sender`
  // than the one that sent a sample within the last second. A pair whose images are farther apart
  // than the scene's `sync` is dropped and counted.
  std::optional<Refusal> Feed(const PushedSample& sample, Time arrived_at, SenderId sender);
  // `sender` has left. If it was the sender of this inbox, clock and sequence of the next one may
  // start again.
  void Leave(SenderId sender);

  // Waits for a sample that was not yet returned; false: `stop`, or none with a driven clock.
  bool Wait(const std::stop_token& stop);
  // Discards the waiting sample, if any; the format of the next one is free.
  void Drop();
  // When the sample taken last was taken by its camera, slave's clock.
  [[nodiscard]] Time taken_at() const;
  [[nodiscard]] CameraHealth health() const;

  // Returns a source of the received samples, one at a time; the inbox must outlive it. `filter`:
  // optional processing of each image.
  std::unique_ptr<FrameSource> OpenFrames(ImageFilter filter);
  std::unique_ptr<StereoSource> OpenPairs();

 private:
  struct State;
  std::unique_ptr<State> state_;
};

}  // namespace palpate
