#include "slave/vision/stereo/frozen_check.h"

#include <cstring>

namespace palpate {
namespace {

constexpr int kEveryRow = 8;

// Fowler's, Noll's and Vo's hash, eight bytes at a time.
std::uint64_t DigestOf(const cv::Mat& picture) noexcept {
  std::uint64_t digest = 14695981039346656037ULL;
  if (picture.dims != 2 || picture.data == nullptr) return digest;
  const std::size_t bytes = static_cast<std::size_t>(picture.cols) * picture.elemSize();
  for (int y = 0; y < picture.rows; y += kEveryRow) {
    const std::uint8_t* row = picture.ptr<std::uint8_t>(y);
    for (std::size_t k = 0; k + sizeof(digest) <= bytes; k += sizeof(digest)) {
      std::uint64_t word = 0;
      std::memcpy(&word, row + k, sizeof(word));
      digest = (digest ^ word) * 1099511628211ULL;
      digest ^= digest >> 32;
    }
  }
  return digest;
}

}  // namespace

bool FrozenCheck::See(const cv::Mat& left, const cv::Mat& right) noexcept {
  bool repeated = false;
  for (const int side : {0, 1}) {
    const cv::Mat& picture = side == 0 ? left : right;
    std::uint64_t& last = digests_[static_cast<std::size_t>(side)];
    const std::uint64_t digest = DigestOf(picture);
    repeated |= seen_ > 0 && !picture.empty() && digest == last;
    last = digest;
  }
  has_noise_ |= !repeated && seen_ > 0 && seen_ < learning_;
  ++seen_;
  return repeated && has_noise_;
}

}  // namespace palpate
