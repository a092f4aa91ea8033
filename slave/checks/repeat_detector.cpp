#include "slave/checks/repeat_detector.h"

#include <algorithm>
#include <cstddef>
#include <cstring>
#include <exception>
#include <utility>

namespace palpate {
namespace {

// Rows of which one is compared [-]. [tuned: BlocksOfTheLastOrTheFirstPictureAreSeen]
constexpr int kEveryRow = 8;
// Length of a piece of a row [px]. [derived: a repeat by chance is one in 10^13 at a noise of two
// levels]
constexpr int kPiece = 16;
// Pieces that repeat; fewer may be an accident [-]. [tuned: repeat_detector_test]
constexpr int kLeastParts = 4;
// Fowler's, Noll's and Vo's hash [-]. [by definition]
constexpr std::uint64_t kStart = 14695981039346656037ULL;

// Eight bytes at a time.
void Mix(std::uint64_t word, std::uint64_t* digest) noexcept {
  *digest = (*digest ^ word) * 1099511628211ULL;
  *digest ^= *digest >> 32;
}

// A pixel that is all zeros or all ones is at the end of its scale.
bool IsEven(const std::uint8_t* piece, std::size_t pixel) noexcept {
  bool even = true;
  for (int i = 0; i < kPiece; ++i) {
    const std::uint8_t* p = piece + static_cast<std::size_t>(i) * pixel;
    const auto is_all = [&](std::uint8_t value) {
      return std::all_of(p, p + pixel, [&](std::uint8_t byte) { return byte == value; });
    };
    if (is_all(0) || is_all(255)) return true;
    even &= std::memcmp(p, piece, pixel) == 0;
  }
  return even;
}

}  // namespace

void RepeatDetector::Digest(const cv::Mat& image, Digests* digests) const {
  digests->whole = kStart;
  digests->parts.clear();
  if (image.dims != 2 || image.data == nullptr) return;
  const std::size_t pixel = image.elemSize(), bytes = kPiece * pixel;
  if (params_.parts) digests->parts.reserve(image.total() / (kPiece * kEveryRow) + kPiece);
  for (int y = 0; y < image.rows; y += kEveryRow) {
    const std::uint8_t* row = image.ptr<std::uint8_t>(y);
    for (int x = 0; x + kPiece <= image.cols; x += kPiece) {
      const std::uint8_t* piece = row + static_cast<std::size_t>(x) * pixel;
      std::uint64_t part = kStart;
      for (std::size_t k = 0; k < bytes; k += sizeof(part)) {
        std::uint64_t word = 0;
        std::memcpy(&word, piece + k, sizeof(word));
        Mix(word, &part);
      }
      Mix(part, &digests->whole);
      if (params_.parts) digests->parts.push_back(IsEven(piece, pixel) ? 0 : part);
    }
  }
}

int RepeatDetector::Repeats(const Digests& now, const Digests& before) noexcept {
  if (now.parts.size() != before.parts.size()) return 0;
  int count = 0;
  for (std::size_t i = 0; i < now.parts.size(); ++i) {
    count += static_cast<int>(now.parts[i] != 0 && now.parts[i] == before.parts[i]);
  }
  return count;
}

// Compressed images of a still scene repeat each other's pieces, whichever two they are.
bool RepeatDetector::HasOldParts(const Eye& eye) noexcept {
  const int first = Repeats(eye.now, eye.first), last = Repeats(eye.now, eye.last);
  if (seen_ < params_.learning) {
    like_first_ += seen_ > 1 ? first : 0;
    like_last_ += seen_ > 1 ? last : 0;
    return false;
  }
  if (like_first_ + like_last_ == 0) return std::max(first, last) >= kLeastParts;
  const auto stand_out = [](int more, int less) { return more > 2 * less + kLeastParts; };
  return stand_out(like_first_, like_last_) && stand_out(first, last);
}

Repeat RepeatDetector::Find(const cv::Mat& left, const cv::Mat& right) noexcept try {
  bool repeated = false, partly = false;
  for (const int side : {0, 1}) {
    const cv::Mat& image = side == 0 ? left : right;
    Eye& eye = eyes_[static_cast<std::size_t>(side)];
    if (image.empty()) continue;
    Digest(image, &eye.now);
    const bool whole = seen_ > 0 && eye.now.whole == eye.last.whole;
    repeated |= whole;
    if (seen_ == 0) eye.first = eye.now;
    if (seen_ > 0 && !whole) partly |= HasOldParts(eye);
    std::swap(eye.last, eye.now);
  }
  has_noise_ |= !repeated && seen_ > 0 && seen_ < params_.learning;
  ++seen_;
  if (!has_noise_ || !(repeated || partly)) return Repeat::kNothing;
  return repeated ? Repeat::kWhole : Repeat::kParts;
} catch (const std::exception&) {  // out of memory
  return Repeat::kNothing;
}

}  // namespace palpate
