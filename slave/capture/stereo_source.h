// Where pairs of pictures come from: files or the simulated site. Depth pictures come one by one,
// as `left` with an empty `right`. One interface; the pipeline cannot tell.
#pragma once

#include <cstdint>
#include <memory>
#include <optional>
#include <stop_token>
#include <string>

#include <opencv2/core/mat.hpp>

#include "shared/state/clock.h"
#include "slave/scene/scene.h"

namespace palpate {

struct StereoPair {
  cv::Mat left, right;         // 8 bit grey, the rig's size; depth: 16 bit and empty
  std::uint64_t sequence = 0;  // from 1
  Time sensed_at{};            // when the pictures were taken (middle of the exposure)
};

class StereoSource {
 public:
  virtual ~StereoSource() = default;
  StereoSource() = default;
  StereoSource(const StereoSource&) = delete;
  StereoSource& operator=(const StereoSource&) = delete;
  // The next pair; blocks until there is one. nullopt: the source has ended or `stop` was
  // requested. Throws std::runtime_error where a source breaks (unreadable file, a pair of two
  // sizes); the message names it.
  virtual std::optional<StereoPair> Next(const std::stop_token& stop) = 0;
  // In words, for people: `files left/*.png (120 pairs)`.
  [[nodiscard]] virtual std::string description() const = 0;
};

// Opens the files of sense.camera.stereo or sense.camera.depth, listed as ListPictures() does; the
// first of each sort of name is paired with the first of the other, and so on. Colour becomes grey
// (ITU-R BT.601); 16-bit pictures are refused, since two eyes scaled differently would not match.
// Depth is one channel of 16 bit. `paced`: pairs come at the scene's rate; otherwise as fast as
// they are read, with stamps at that rate. Throws std::runtime_error: nothing matches, left and
// right are not equally many (how many) or numbered differently, the first pair is unreadable. Not
// for simulated cameras.
std::unique_ptr<StereoSource> OpenStereoFiles(const Scene& scene, bool paced);

}  // namespace palpate
