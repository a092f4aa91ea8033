#include "slave/vision/grey.h"

#include <algorithm>
#include <bit>
#include <cmath>
#include <stdexcept>

#include <opencv2/core.hpp>

namespace palpate {
namespace {

template <typename Pixel, int kChannels, typename Level>
void ReadAs(const cv::Mat& image, const cv::Rect& window, int shift, int full_scale,
            Level* out) noexcept {
  for (int y = window.y; y < window.y + window.height; ++y) {
    const Pixel* in = image.ptr<Pixel>(y) + static_cast<std::ptrdiff_t>(window.x) * kChannels;
    for (int x = 0; x < window.width; ++x, in += kChannels, ++out) {
      int level = in[0];
      if constexpr (kChannels == 3) level = (29 * in[0] + 150 * in[1] + 77 * in[2] + 128) >> 8;
      if constexpr (sizeof(Pixel) == 2) level = std::min(level >> shift, full_scale);
      *out = static_cast<Level>(level);
    }
  }
}

}  // namespace

GreyFormat::GreyFormat(const cv::Mat& first) : type_(first.type()), size_(first.size()) {
  if (first.empty() || first.dims != 2) throw std::runtime_error("the first image is empty");
  const bool depth_known = first.depth() == CV_8U || first.depth() == CV_16U;
  if (!depth_known || (first.channels() != 1 && first.channels() != 3)) {
    throw std::runtime_error("the first image is " + cv::typeToString(type_) +
                             ": expected 8 and 16 bit unsigned, 1 or 3 channels");
  }
  if (first.depth() == CV_16U) {
    double brightest = 0;
    cv::minMaxLoc(first.reshape(1), nullptr, &brightest);
    const int bits =
        std::max(8, static_cast<int>(std::bit_width(static_cast<unsigned>(brightest))));
    shift_ = std::max(0, bits - 11);
    full_scale_ = (1 << (bits - shift_)) - 1;
  }
}

template <typename Level>
void GreyFormat::Read(const cv::Mat& image, const cv::Rect& window, Level* out) const noexcept {
  switch (type_) {
    case CV_8UC1:
      return ReadAs<std::uint8_t, 1>(image, window, shift_, full_scale_, out);
    case CV_8UC3:
      return ReadAs<std::uint8_t, 3>(image, window, shift_, full_scale_, out);
    case CV_16UC1:
      return ReadAs<std::uint16_t, 1>(image, window, shift_, full_scale_, out);
    case CV_16UC3:
      return ReadAs<std::uint16_t, 3>(image, window, shift_, full_scale_, out);
  }
}
template void GreyFormat::Read(const cv::Mat&, const cv::Rect&, std::int16_t*) const noexcept;
template void GreyFormat::Read(const cv::Mat&, const cv::Rect&, float*) const noexcept;

double VarianceOf(const GreyPatch& p) {
  double sum = 0, square = 0;
  for (const std::int16_t level : p.levels) sum += level, square += level * level;
  const auto n = static_cast<double>(p.levels.size());
  return square / n - sum * sum / (n * n);
}

double NoiseOf(const GreyPatch& p) {
  double sum = 0;
  for (int y = 1; y + 1 < p.height; ++y) {
    for (int x = 1; x + 1 < p.width; ++x) {
      const int cross = p.At(x - 1, y) + p.At(x + 1, y) + p.At(x, y - 1) + p.At(x, y + 1);
      const int corners =
          p.At(x - 1, y - 1) + p.At(x + 1, y - 1) + p.At(x - 1, y + 1) + p.At(x + 1, y + 1);
      sum += std::abs(4 * p.At(x, y) - 2 * cross + corners);
    }
  }
  return std::sqrt(M_PI / 2) * sum / (6.0 * (p.width - 2) * (p.height - 2));
}

void Shrink(const GreyPatch& patch, int factor, GreyPatch& out) {
  out.Resize(patch.width / factor, patch.height / factor);
  const int area = factor * factor;
  for (int y = 0; y < out.height; ++y) {
    for (int x = 0; x < out.width; ++x) {
      int sum = 0;
      for (int j = 0; j < factor; ++j) {
        const std::int16_t* in = patch.Row(y * factor + j) + x * factor;
        for (int i = 0; i < factor; ++i) sum += in[i];
      }
      out.Row(y)[x] = static_cast<std::int16_t>((sum + area / 2) / area);
    }
  }
}

}  // namespace palpate
