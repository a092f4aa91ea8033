// Whether a camera has stopped while its pictures go on coming, or parts of them are old: the same
// grey levels again, which noise never gives.
#pragma once

#include <array>
#include <cstdint>
#include <vector>

#include <opencv2/core/mat.hpp>

namespace palpate {

// One thread; no allocation after the first pair.
class FrozenCheck {
 public:
  // `learning`: the first pairs; where each of them repeats the one before, the source has no
  // noise, and a repeat says nothing. Where parts of them repeat, as compression has them, a part
  // says nothing, unless it is the first picture's more often than the last one's.
  explicit FrozenCheck(int learning) : learning_(learning) {}

  // True: one of the two shows what it showed in the last pair, to the grey level (in every eighth
  // row), though the source has noise; or parts of it are as in the last or in the first pair, as
  // a line that loses blocks leaves them. An empty picture is none.
  bool Check(const cv::Mat& left, const cv::Mat& right) noexcept;

 private:
  static constexpr int kLeastParts = 4;  // pieces of a row; less may be an accident
  struct Digests {
    std::uint64_t whole = 0;
    std::vector<std::uint64_t> parts;  // 0: says nothing, since it is even or at the scale's end
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
