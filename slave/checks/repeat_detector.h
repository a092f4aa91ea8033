// Detects a frozen source: the grey levels of an image repeat, which noise prevents.
#pragma once

#include <array>
#include <cstdint>
#include <optional>

#include <opencv2/core/mat.hpp>

namespace palpate {

// RepeatDetector is for one thread and does not allocate.
class RepeatDetector {
 public:
  struct Params {
    // Number of first samples. If each of them repeats the one before, the source has no noise, and
    // repetition is no evidence.
    int learning = 0;
    bool has_noise = false;  // whether the noise is known
  };
  explicit RepeatDetector(const Params& params)
      : learning_(params.learning), has_noise_(params.has_noise) {}

  // Returns whether an image equals the one before in every eighth row, although the source has
  // noise. An empty image is not compared.
  bool Repeats(const cv::Mat& left, const cv::Mat& right = {}) noexcept;

 private:
  int learning_;
  int seen_ = 0;
  bool has_noise_;
  std::array<std::optional<std::uint64_t>, 2> last_;  // digests of both images
};

}  // namespace palpate
