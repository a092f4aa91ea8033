// Whether a camera has stopped while its pictures go on coming: the same picture again, which noise
// never gives.
#pragma once

#include <array>
#include <cstdint>

#include <opencv2/core/mat.hpp>

namespace palpate {

// One thread; no allocation.
class FrozenCheck {
 public:
  // `learning`: the first pairs; where each of them repeats the one before, the source has no
  // noise, and a repeat says nothing.
  explicit FrozenCheck(int learning) : learning_(learning) {}

  // True: one of the two shows what it showed in the last pair, to the grey level (in every eighth
  // row), though the source has noise. An empty picture is none.
  bool See(const cv::Mat& left, const cv::Mat& right) noexcept;

 private:
  int learning_;
  int seen_ = 0;
  bool has_noise_ = false;
  std::array<std::uint64_t, 2> digests_{};
};

}  // namespace palpate
