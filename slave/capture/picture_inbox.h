// Where drivers in any language push pictures (FeedPictures): the newest one wins, and what is not
// the scene's is refused in words.
#pragma once

#include <cstdint>
#include <memory>
#include <optional>
#include <stop_token>
#include <string>

#include "shared/state/clock.h"
#include "slave/capture/frame_source.h"

namespace palpate {

// A picture as it was pushed.
struct PushedPicture {
  enum class Encoding : std::uint8_t {
    kJpeg,
    kPng,
    kGrey8,
    kBgr8,
    kGrey16
  } encoding = Encoding::kJpeg;
  const std::string* data = nullptr;  // outlives the call
  unsigned width = 0, height = 0;     // [px]; of files 0: as the file says
};

// What the eyes saw at one instant, as it was pushed. Sender's clock.
struct PushedSample {
  std::uint64_t sequence = 0;  // 0: not told
  Time sensed_at{};
  PushedPicture picture;
  std::optional<PushedPicture> right;
  std::optional<Time> right_sensed_at;
};

// Thread-safe. Holds one sample.
class PictureInbox {
 public:
  using SenderId = std::uint64_t;  // never 0

  // For the scene's camera, pair or depth pictures, whose source is a stream.
  explicit PictureInbox(const Scene& scene);
  ~PictureInbox();
  PictureInbox(const PictureInbox&) = delete;
  PictureInbox& operator=(const PictureInbox&) = delete;

  struct Refusal {
    std::string why;
    bool is_held = false;  // by another sender: nothing is wrong with the sample
  };
  // Decodes and keeps a sample that arrived at `arrived_at`. Refused: what does not decode; another
  // size, kind or number of channels than the scene's or than the first one's; a sequence that does
  // not rise, a clock that does not go forward; far more samples than the scene's rate; another
  // `sender` than the one from whom a sample came less than a second ago. A pair whose pictures
  // were taken farther apart than the scene's `sync` is dropped and counted.
  std::optional<Refusal> Feed(const PushedSample& sample, Time arrived_at, SenderId sender);
  // `sender` has left, if it fed us: the next one's clock and sequence begin anew.
  void Leave(SenderId sender);

  // Waits until there is a sample that nobody has taken; false: `stop`.
  bool Wait(const std::stop_token& stop);
  // Throws away the one that waits, if any; the next one may be unlike those before.
  void Drop();
  // When the sample taken last was taken by its camera, slave's clock.
  [[nodiscard]] Time taken_at() const;
  [[nodiscard]] CameraHealth health() const;

  // What gives the samples, one at a time; the inbox must outlive them. `filter`: what becomes of
  // each picture, if anything.
  std::unique_ptr<FrameSource> OpenFrames(PictureFilter filter);
  std::unique_ptr<StereoSource> OpenPairs();

 private:
  struct State;
  std::unique_ptr<State> state_;
};

}  // namespace palpate
