// Detects a frozen source, or old parts of an image: the same grey levels repeat, which noise
// prevents.
#pragma once

#include <array>
#include <cstdint>
#include <vector>

#include <opencv2/core/mat.hpp>

namespace palpate {

enum class Repeat : std::uint8_t { kNothing, kParts, kWhole };

// One thread; no allocation after the first images.
class RepeatDetector {
 public:
  struct Params {
    // Number of first samples; if each of them repeats the previous one, the source has no noise
    // and repetition is no evidence. If parts of them repeat, as with compression, a repeated part
    // is no evidence, unless it repeats the first image more often than the last one.
    int learning = 0;
    bool has_noise = false;  // known before
    bool parts = true;       // are looked for
  };
  explicit RepeatDetector(const Params& params) : params_(params), has_noise_(params.has_noise) {}

  // What of the images repeats, although the source has noise: the grey levels of the last sample
  // (in every eighth row); or parts of the last or the first sample, as after lost blocks on a
  // link. An empty image is not checked.
  Repeat Find(const cv::Mat& left, const cv::Mat& right = {}) noexcept;

 private:
  struct Digests {
    std::uint64_t whole = 0;
    std::vector<std::uint64_t> parts;  // 0: no evidence, because it is uniform or saturated
  };
  struct Eye {
    Digests first, last, now;
  };
  void Digest(const cv::Mat& image, Digests* digests) const;
  static int Repeats(const Digests& now, const Digests& before) noexcept;
  bool HasOldParts(const Eye& eye) noexcept;

  Params params_;
  int seen_ = 0;
  bool has_noise_;
  int like_first_ = 0, like_last_ = 0;  // pieces, while learning
  std::array<Eye, 2> eyes_;
};

}  // namespace palpate
