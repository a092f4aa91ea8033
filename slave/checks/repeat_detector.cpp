#include "slave/checks/repeat_detector.h"

#include <cstddef>
#include <cstring>

namespace palpate {
namespace {

// One row of this many is compared [-]. [by definition]
constexpr int kEveryRow = 8;

// Hash of Fowler, Noll and Vo, eight bytes at a time.
std::uint64_t DigestOf(const cv::Mat& image) noexcept {
  std::uint64_t digest = 14695981039346656037ULL;
  const std::size_t bytes = static_cast<std::size_t>(image.cols) * image.elemSize();
  for (int y = 0; y < image.rows; y += kEveryRow) {
    const std::uint8_t* row = image.ptr<std::uint8_t>(y);
    for (std::size_t k = 0; k + sizeof(std::uint64_t) <= bytes; k += sizeof(std::uint64_t)) {
      std::uint64_t word = 0;
      std::memcpy(&word, row + k, sizeof(word));
      digest = (digest ^ word) * 1099511628211ULL;
      digest ^= digest >> 32;
    }
  }
  return digest;
}

}  // namespace

bool RepeatDetector::Repeats(const cv::Mat& left, const cv::Mat& right) noexcept {
  bool repeated = false;
  for (const std::size_t side : {0, 1}) {
    const cv::Mat& image = side == 0 ? left : right;
    if (image.dims != 2 || image.data == nullptr) continue;
    const std::uint64_t digest = DigestOf(image);
    repeated |= digest == last_[side];
    last_[side] = digest;
  }
  has_noise_ |= !repeated && seen_ > 0 && seen_ < learning_;
  ++seen_;
  return has_noise_ && repeated;
}

}  // namespace palpate
