// Detects a frozen source: the grey levels of an image repeat, which noise prevents.
#pragma once

#include <array>
#include <cstddef>
#include <cstdint>
#include <optional>

#include <opencv2/core/mat.hpp>

namespace palpate {

// RepeatDetector is for one thread and does not allocate.
class RepeatDetector {
 public:
  struct Params {
    // Number of first samples. If a few of them differ from the one before in `noisy_share` of all
    // parts of the image, the source has noise. Without noise, repetition is no evidence.
    int learning = 0;
    double noisy_share = 0;  // more than what moves in the view; 0: any part
    bool has_noise = false;  // whether the noise is known
  };
  explicit RepeatDetector(const Params& params)
      : learning_(params.learning),
        noisy_share_(params.noisy_share),
        has_noise_(params.has_noise) {}

  // Returns whether an image equals the one before in every eighth row, although the source has
  // noise. An empty image is not compared.
  bool Repeats(const cv::Mat& left, const cv::Mat& right = {}) noexcept;

 private:
  static constexpr std::size_t kBands = 8;
  using Digests = std::array<std::uint64_t, kBands * kBands>;  // of the parts of an image
  [[nodiscard]] static Digests DigestsOf(const cv::Mat& image) noexcept;

  int learning_;
  double noisy_share_;
  int seen_ = 0, noisy_ = 0;  // samples; those that differ from the one before as noise does
  bool has_noise_;
  std::array<std::optional<Digests>, 2> last_;  // of both images
};

}  // namespace palpate
