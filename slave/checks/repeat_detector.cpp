#include "slave/checks/repeat_detector.h"

#include <algorithm>
#include <cstring>

namespace palpate {
namespace {

// One row of this many is compared [-]. [by definition]
constexpr int kEveryRow = 8;
// Samples that must differ as noise does: a change of the light is over within one. [by definition]
constexpr int kNoisy = 3;

// Hash of Fowler, Noll and Vo, eight bytes at a time.
void Add(const std::uint8_t* begin, std::size_t bytes, std::uint64_t* digest) noexcept {
  for (std::size_t k = 0; k < bytes; k += sizeof(std::uint64_t)) {
    std::uint64_t word = 0;
    std::memcpy(&word, begin + k, std::min(sizeof(word), bytes - k));
    *digest = (*digest ^ word) * 1099511628211ULL;
    *digest ^= *digest >> 32;
  }
}

}  // namespace

RepeatDetector::Digests RepeatDetector::DigestsOf(const cv::Mat& image) noexcept {
  Digests digests;
  digests.fill(14695981039346656037ULL);
  const std::size_t bytes = static_cast<std::size_t>(image.cols) * image.elemSize();
  const auto rows = static_cast<std::size_t>(image.rows);
  for (int y = 0; y < image.rows; y += kEveryRow) {
    const std::uint8_t* row = image.ptr<std::uint8_t>(y);
    const std::size_t band = static_cast<std::size_t>(y) * kBands / rows;
    for (std::size_t part = 0; part < kBands; ++part) {
      const std::size_t begin = part * bytes / kBands, end = (part + 1) * bytes / kBands;
      Add(row + begin, end - begin, &digests[band * kBands + part]);
    }
  }
  return digests;
}

bool RepeatDetector::Repeats(const cv::Mat& left, const cv::Mat& right) noexcept {
  bool repeated = false, noisy = false;
  for (const std::size_t side : {0, 1}) {
    const cv::Mat& image = side == 0 ? left : right;
    if (image.dims != 2 || image.data == nullptr) continue;
    const Digests digests = DigestsOf(image);
    if (last_[side]) {
      std::size_t changed = 0;
      for (std::size_t i = 0; i < digests.size(); ++i) changed += digests[i] != (*last_[side])[i];
      repeated |= changed == 0;
      noisy |= changed > 0 &&
               static_cast<double>(changed) >= noisy_share_ * static_cast<double>(digests.size());
    }
    last_[side] = digests;
  }
  if (!repeated && noisy && seen_ < learning_) ++noisy_;
  has_noise_ |= noisy_ >= kNoisy;
  ++seen_;
  return has_noise_ && repeated;
}

}  // namespace palpate
