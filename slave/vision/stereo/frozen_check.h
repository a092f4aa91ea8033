// Detects a frozen camera, or old parts of an image: the same grey levels repeat, which noise
// prevents.
#pragma once

#include <array>
#include <cstdint>
#include <vector>

#include <opencv2/core/mat.hpp>

namespace palpate {

// One thread; no allocation after the first pair.
class FrozenCheck {
 public:
  // `learning`: number of first pairs; if each of them repeats the previous one, the source has no
  // noise and repetition is no evidence. If parts of them repeat, as with compression, a repeated
  // part is no evidence, unless it repeats the first image more often than the last one.
  explicit FrozenCheck(int learning) : learning_(learning) {}

  // True: an image repeats its grey levels of the last pair (in every eighth row), although the
  // source has noise; or parts of it are those of the last or the first pair, as after lost blocks
  // on a link. An empty image is not checked.
  bool Check(const cv::Mat& left, const cv::Mat& right) noexcept;

 private:
  static constexpr int kLeastParts = 4;  // pieces of a row; less may be an accident
  struct Digests {
    std::uint64_t whole = 0;
    std::vector<std::uint64_t> parts;  // 0: no evidence, because it is uniform or saturated
  };
  struct Eye {
    Digests first, last, now;
  };
  static void Digest(const cv::Mat& picture, Digests* digests);
  static int Repeats(const Digests& now, const Digests& before) noexcept;
  bool HasOldParts(const Eye& eye) noexcept;

  int learning_;
  int seen_ = 0;
  bool has_noise_ = false;
  int like_first_ = 0, like_last_ = 0;  // pieces, while learning
  std::array<Eye, 2> eyes_;
};

}  // namespace palpate
