// Reads any accepted image as grey levels, a window at a time, so that small windows do not need a
// conversion of the whole image.
#pragma once

#include <cstddef>
#include <cstdint>
#include <vector>

#include <opencv2/core/mat.hpp>

namespace palpate {

// A small grey image, row after row. Levels lie in [0, 2047], so that 512 products of two of them
// fit in 32 bits.
struct GreyPatch {
  int width = 0, height = 0;
  std::vector<std::int16_t> levels;  // width x height

  void Resize(int new_width, int new_height) {
    width = new_width;
    height = new_height;
    levels.resize(static_cast<std::size_t>(width) * static_cast<std::size_t>(height));
  }
  [[nodiscard]] std::int16_t* Row(int y) { return levels.data() + Index(0, y); }
  [[nodiscard]] const std::int16_t* Row(int y) const { return levels.data() + Index(0, y); }
  [[nodiscard]] std::int16_t At(int x, int y) const { return levels[Index(x, y)]; }
  [[nodiscard]] cv::Mat Mat() const {  // the levels without a copy; read-only
    return {height, width, CV_16SC1, const_cast<std::int16_t*>(levels.data())};
  }

 private:
  [[nodiscard]] std::size_t Index(int x, int y) const {
    return static_cast<std::size_t>(y) * static_cast<std::size_t>(width) +
           static_cast<std::size_t>(x);
  }
};

// Conversion of a source's images to grey levels: determined by the first image, the same for all.
// 8 bit: unchanged. 16 bit: shifted down so that the range of the first image (at least 8 bits)
// fits in 11; brighter points later saturate. Colour is BGR, weighted as in ITU-R BT.601.
class GreyFormat {
 public:
  // Throws std::runtime_error: empty, a depth other than 8 or 16 bit, channels other than 1 or 3.
  explicit GreyFormat(const cv::Mat& first);

  [[nodiscard]] bool Fits(const cv::Mat& image) const noexcept {
    return image.dims == 2 && image.type() == type_ && image.cols == size_.width &&
           image.rows == size_.height && image.data != nullptr;
  }
  // Reads grey levels. `window` must be inside `image`, and `image` must have the format. `out`
  // must have space for width x height levels, std::int16_t or float.
  template <typename Level>
  void Read(const cv::Mat& image, const cv::Rect& window, Level* out) const noexcept;
  void Read(const cv::Mat& image, const cv::Rect& window, GreyPatch& out) const {
    out.Resize(window.width, window.height);
    Read(image, window, out.levels.data());
  }
  // Returns the grey levels per 1/255 of full scale.
  [[nodiscard]] double levels_per_255() const { return full_scale_ / 255.0; }
  [[nodiscard]] cv::Size size() const { return size_; }

 private:
  int type_ = 0;
  cv::Size size_;
  int shift_ = 0;         // 16 bit only
  int full_scale_ = 255;  // the largest level
};

// Bilinear level between four pixels, `u` and `v` [px] right of and below the pixel `at`, [0, 1).
template <typename Pixel>
float Bilinear(const Pixel* at, std::ptrdiff_t stride, float u, float v) noexcept {
  const auto a = static_cast<float>(at[0]), b = static_cast<float>(at[1]);
  const auto c = static_cast<float>(at[stride]), d = static_cast<float>(at[stride + 1]);
  const float above = a + u * (b - a), below = c + u * (d - c);
  return above + v * (below - above);
}

// Returns the standard deviation of white noise [levels], from the part of the image that neither a
// plane nor a straight edge along an axis explains (J. Immerkaer, CVIU 64, 1996). At least 3 x 3.
double NoiseOf(const GreyPatch& p);

// Variance of its grey levels [levels^2].
double VarianceOf(const GreyPatch& p);

// Mean of `factor` x `factor` blocks; incomplete blocks at the right and lower edge are omitted.
void Shrink(const GreyPatch& patch, int factor, GreyPatch& out);

}  // namespace palpate
