#include "slave/simulator/environment/painting.h"

#include <algorithm>
#include <cmath>
#include <limits>
#include <numbers>
#include <random>

#include <opencv2/core.hpp>
#include <opencv2/imgproc.hpp>

#include "slave/mesh/index.h"

namespace palpate::simulation {
namespace {

constexpr double kOne = 65536;  // 16.16 fixed point

// White noise, smoothed across the seam, with mean 0 and standard deviation 1.
cv::Mat SmoothNoise(std::uint32_t seed, double grain) {
  // A better generator makes the seed, because cv::RNG yields similar numbers for neighbouring
  // seeds.
  cv::RNG random{std::mt19937_64{seed}()};
  cv::Mat noise(Texture::kSize, Texture::kSize, CV_32F);
  random.fill(noise, cv::RNG::NORMAL, 0, 1);
  const double sigma = std::clamp(grain / 2, 0.5, 40.0);
  const int border = static_cast<int>(std::ceil(4 * sigma));
  cv::Mat wide, smooth;
  cv::copyMakeBorder(noise, wide, border, border, border, border, cv::BORDER_WRAP);
  cv::GaussianBlur(wide, smooth, {}, sigma);
  cv::Mat tile = smooth({border, border, Texture::kSize, Texture::kSize}).clone();
  cv::Scalar mean, deviation;
  cv::meanStdDev(tile, mean, deviation);
  tile = (tile - mean[0]) / deviation[0];
  return tile;
}

// Whole texture periods do not matter, so far-away places stay exact.
std::uint32_t ToFixed(double texels) {
  const double wrapped = texels - Texture::kSize * std::floor(texels / Texture::kSize);
  return static_cast<std::uint32_t>(wrapped * kOne);
}

std::uint32_t StepToFixed(double texels) {
  return static_cast<std::uint32_t>(
      static_cast<std::int64_t>(std::clamp(texels, -1e4, 1e4) * kOne));
}

constexpr int kNoiseMargin = 256;        // range of random offsets of an image's noise [px]
constexpr double kFlickerPeriod = 41.3;  // [images]

// Returns a light field that is brightest at the upper left and darker by `fall` at the lower
// right.
cv::Mat Light(const cv::Size& size, double fall) {
  cv::Mat light(size, CV_32F);
  for (int y = 0; y < size.height; ++y) {
    for (int x = 0; x < size.width; ++x) {
      const double way = 0.5 * (x / (size.width - 1.0) + y / (size.height - 1.0));
      light.at<float>(y, x) = static_cast<float>(1 - fall * way);
    }
  }
  return light;
}

cv::Mat Noise(const cv::Size& size, double sigma, std::uint32_t seed) {
  cv::Mat noise(size.height + kNoiseMargin, size.width + kNoiseMargin, CV_32F, cv::Scalar(0));
  if (sigma > 0) cv::RNG(std::mt19937_64(seed)()).fill(noise, cv::RNG::NORMAL, 0, sigma);
  return noise;
}

}  // namespace

Texture Texture::Speckle(std::uint32_t seed, double grain, float grey, float contrast) {
  Texture texture;
  texture.texels_ = SmoothNoise(seed, grain);
  texture.texels_.forEach<float>(
      [&](float& t, const int*) { t = grey + contrast * std::clamp(t / 2, -1.0F, 1.0F); });
  return texture;
}

Texture Texture::Blotches(std::uint32_t seed, double grain, float dark, float light) {
  Texture texture;
  texture.texels_ = SmoothNoise(seed, grain);
  texture.texels_.forEach<float>([&](float& t, const int*) {
    t = dark + (light - dark) * std::clamp(0.5F + 2 * t, 0.0F, 1.0F);
  });
  return texture;
}

inline float Texture::Sample(std::uint32_t u, std::uint32_t v) const {
  constexpr std::uint32_t kMask = kSize - 1;
  const auto* texels = texels_.ptr<float>();
  const float fu = static_cast<float>(u & 0xffff) * static_cast<float>(1 / kOne);
  const float fv = static_cast<float>(v & 0xffff) * static_cast<float>(1 / kOne);
  const std::uint32_t x0 = (u >> 16) & kMask, x1 = (x0 + 1) & kMask;
  const std::uint32_t y0 = ((v >> 16) & kMask) * kSize, y1 = (((v >> 16) + 1) & kMask) * kSize;
  const float above = texels[y0 + x0] + fu * (texels[y0 + x1] - texels[y0 + x0]);
  const float below = texels[y1 + x0] + fu * (texels[y1 + x1] - texels[y1 + x0]);
  return above + fv * (below - above);
}

void Texture::FillFacets(cv::Mat& canvas, const std::vector<std::array<int, 3>>& facets,
                         const std::vector<std::optional<Eigen::Vector2d>>& at,
                         const std::vector<Eigen::Vector2d>& from) const {
  for (const auto& facet : facets) {
    const std::size_t i = Index(facet[0]), j = Index(facet[1]), k = Index(facet[2]);
    if (!at[i] || !at[j] || !at[k]) continue;
    const Eigen::Vector2d a = *at[j] - *at[i], b = *at[k] - *at[i];
    if (!(a.x() * b.y() - a.y() * b.x() > 0)) continue;
    Fill(canvas, {*at[i], *at[j], *at[k]}, {from[i], from[j], from[k]});
  }
}

void Texture::Fill(cv::Mat& canvas, const std::array<Eigen::Vector2d, 3>& p,
                   const std::array<Eigen::Vector2d, 3>& from) const {
  const double low = std::min({p[0].y(), p[1].y(), p[2].y()});
  const double high = std::max({p[0].y(), p[1].y(), p[2].y()});
  const int first = static_cast<int>(std::ceil(std::max(low, 0.0)));
  const int last = static_cast<int>(std::floor(std::min(high, canvas.rows - 1.0)));
  if (first > last) return;
  Eigen::Matrix2d to, texel;
  to << p[1] - p[0], p[2] - p[0];
  texel << from[1] - from[0], from[2] - from[0];
  const double twice = to(0, 0) * to(1, 1) - to(0, 1) * to(1, 0);
  if (std::abs(twice) < 1e-12) return;
  Eigen::Matrix2d inverse;
  inverse << to(1, 1), -to(0, 1), -to(1, 0), to(0, 0);
  const Eigen::Matrix2d step = texel * inverse / twice;  // texels per pixel
  const std::uint32_t du = StepToFixed(step(0, 0)), dv = StepToFixed(step(1, 0));
  for (int row = first; row <= last; ++row) {
    double left = std::numeric_limits<double>::infinity(), right = -left;
    for (std::size_t i = 0; i < 3; ++i) {
      const Eigen::Vector2d &a = p[i], &b = p[(i + 1) % 3];
      if ((a.y() < row && b.y() < row) || (a.y() > row && b.y() > row) || a.y() == b.y()) continue;
      const double x = a.x() + (row - a.y()) / (b.y() - a.y()) * (b.x() - a.x());
      left = std::min(left, x);
      right = std::max(right, x);
    }
    const int x0 = static_cast<int>(std::ceil(std::clamp(left, 0.0, canvas.cols + 1.0) - 1e-9));
    const int x1 = static_cast<int>(std::floor(std::clamp(right, -1.0, canvas.cols - 1.0)));
    if (x0 > x1) continue;
    const Eigen::Vector2d start = from[0] + step * (Eigen::Vector2d(x0, row) - p[0]);
    std::uint32_t u = ToFixed(start.x()), v = ToFixed(start.y());
    auto* out = canvas.ptr<float>(row);
    for (int x = x0; x <= x1; ++x, u += du, v += dv) out[x] = Sample(u, v);
  }
}

namespace {

// Change of coverage from one pixel to the next, row by row. Pixel (0, 0) of the window spans 0
// to 1.
class Coverage {
 public:
  explicit Coverage(const cv::Size& size)
      : size_(size), change_(size.height, size.width + 2, CV_32F, cv::Scalar(0)) {}
  void AddEdge(const Eigen::Vector2d& a, const Eigen::Vector2d& b);
  [[nodiscard]] cv::Mat Sum() const;

 private:
  void AddRowPiece(int row, double x0, double y0, double x1, double y1);

  cv::Size size_;
  cv::Mat change_;
};

// Cuts the edge into pieces that stay within one row.
void Coverage::AddEdge(const Eigen::Vector2d& a, const Eigen::Vector2d& b) {
  if (a.y() == b.y()) return;
  const double slope = (b.x() - a.x()) / (b.y() - a.y());
  const double height = size_.height;
  const double from = std::clamp(a.y(), 0.0, height), to = std::clamp(b.y(), 0.0, height);
  if (from == to) return;
  const double low = std::min(from, to), high = std::max(from, to);
  const int last = std::min(size_.height - 1, static_cast<int>(high));
  for (int row = static_cast<int>(low); row <= last; ++row) {
    const double y0 = std::max(low, static_cast<double>(row));
    const double y1 = std::min(high, row + 1.0);
    if (!(y1 > y0)) continue;
    const double x0 = a.x() + slope * (y0 - a.y()), x1 = a.x() + slope * (y1 - a.y());
    if (to > from) {
      AddRowPiece(row, x0, y0, x1, y1);
    } else {
      AddRowPiece(row, x1, y1, x0, y0);
    }
  }
}

// Everything right of the piece is covered by its height; the pixels it passes, in part.
void Coverage::AddRowPiece(int row, double x0, double y0, double x1, double y1) {
  auto* change = change_.ptr<float>(row);
  const double width = size_.width, dy = y1 - y0;
  const double left = std::min(x0, x1), right = std::max(x0, x1);
  const auto add = [&](int pixel, double cover, double middle) {
    // `middle`: mean position of the piece within the pixel, 0 left to 1 right.
    change[pixel] += static_cast<float>(cover * (1 - middle));
    change[pixel + 1] += static_cast<float>(cover * middle);
  };
  if (right <= 0) return add(0, dy, 0);
  if (left >= width) return;
  if (right - left < 1e-12) {
    const int pixel = std::min(static_cast<int>(left), size_.width - 1);
    return add(pixel, dy, left - pixel);
  }
  const double per_x = dy / (right - left);
  if (left < 0) add(0, -left * per_x, 0);
  const double end = std::min(right, width);
  for (double x = std::max(left, 0.0); x < end;) {
    const int pixel = std::min(static_cast<int>(x), size_.width - 1);
    const double next = std::min(end, pixel + 1.0);
    add(pixel, (next - x) * per_x, 0.5 * (x + next) - pixel);
    x = next;
  }
}

cv::Mat Coverage::Sum() const {
  cv::Mat alpha(size_, CV_32F);
  for (int row = 0; row < size_.height; ++row) {
    const auto* change = change_.ptr<float>(row);
    auto* out = alpha.ptr<float>(row);
    float sum = 0;
    for (int x = 0; x < size_.width; ++x) {
      sum += change[x];
      out[x] = std::min(std::abs(sum), 1.0F);
    }
  }
  return alpha;
}

}  // namespace

cv::Mat CoverageOf(const std::vector<std::vector<Eigen::Vector2d>>& polygons,
                   const cv::Rect& window) {
  if (window.empty()) return {};
  Coverage coverage(window.size());
  const Eigen::Vector2d corner(window.x - 0.5, window.y - 0.5);
  for (const auto& polygon : polygons) {
    for (std::size_t i = 0; i < polygon.size(); ++i) {
      coverage.AddEdge(polygon[i] - corner, polygon[(i + 1) % polygon.size()] - corner);
    }
  }
  return coverage.Sum();
}

cv::Rect WindowAround(const std::vector<Eigen::Vector2d>& polygon, int margin,
                      const cv::Size& size) {
  constexpr double kInfinity = std::numeric_limits<double>::infinity();
  Eigen::Vector2d low(kInfinity, kInfinity), high(-kInfinity, -kInfinity);
  for (const Eigen::Vector2d& p : polygon) {
    low = low.cwiseMin(p);
    high = high.cwiseMax(p);
  }
  const auto clip = [](double v, int limit) {
    return static_cast<int>(std::clamp(v, 0.0, static_cast<double>(limit)));
  };
  const int x0 = clip(std::floor(low.x()) - margin, size.width);
  const int y0 = clip(std::floor(low.y()) - margin, size.height);
  const int x1 = clip(std::ceil(high.x()) + margin + 1, size.width);
  const int y1 = clip(std::ceil(high.y()) + margin + 1, size.height);
  return {x0, y0, std::max(0, x1 - x0), std::max(0, y1 - y0)};
}

Exposure::Exposure(const SiteOptions& options, const std::array<int, 2>& size)
    : blur_(options.blur),
      flicker_(options.flicker),
      reach_(options.blur > 0 ? static_cast<int>(std::ceil(4 * options.blur)) : 0),
      light_(Light({size[0], size[1]}, options.lighting)),
      noise_(Noise({size[0], size[1]}, options.noise, options.seed + 2)),
      random_(options.seed) {}

void Exposure::Blur(cv::Mat& seen) const {
  if (reach_ == 0) return;
  cv::GaussianBlur(seen, seen, {2 * reach_ + 1, 2 * reach_ + 1}, blur_, blur_,
                   cv::BORDER_REPLICATE | cv::BORDER_ISOLATED);
}

void Exposure::Advance() {
  const double phase = 2 * std::numbers::pi * static_cast<double>(instants_++) / kFlickerPeriod;
  gain_ = static_cast<float>(1 + flicker_ * std::sin(phase));
}

cv::Mat Exposure::Expose(const cv::Mat& seen) {
  const int left = static_cast<int>(random_() % kNoiseMargin);
  const int top = static_cast<int>(random_() % kNoiseMargin);
  const cv::Mat noise = noise_({left, top, seen.cols, seen.rows});
  cv::Mat image;
  cv::Mat(gain_ * seen.mul(light_) + noise).convertTo(image, CV_8U);
  return image;
}

}  // namespace palpate::simulation
