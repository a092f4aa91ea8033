#include "slave/site/coverage.h"

#include <algorithm>
#include <cmath>
#include <limits>

namespace palpate::site {

Coverage::Coverage(const cv::Rect& window)
    : window_(window),
      stride_(window.width + 2),
      change_(static_cast<std::size_t>(stride_) * static_cast<std::size_t>(window.height), 0) {}

void Coverage::Add(const std::vector<Eigen::Vector2d>& polygon) {
  if (window_.empty()) return;
  // Pixel (0, 0) of the window spans 0 to 1 from here on.
  const Eigen::Vector2d corner(window_.x - 0.5, window_.y - 0.5);
  for (std::size_t i = 0; i < polygon.size(); ++i) {
    AddEdge(polygon[i] - corner, polygon[(i + 1) % polygon.size()] - corner);
  }
}

// Cuts the edge into pieces that stay within one row.
void Coverage::AddEdge(const Eigen::Vector2d& a, const Eigen::Vector2d& b) {
  if (a.y() == b.y()) return;
  const double slope = (b.x() - a.x()) / (b.y() - a.y());
  const double height = window_.height;
  const double from = std::clamp(a.y(), 0.0, height), to = std::clamp(b.y(), 0.0, height);
  if (from == to) return;
  const double low = std::min(from, to), high = std::max(from, to);
  const int last = std::min(window_.height - 1, static_cast<int>(high));
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
  float* change = change_.data() + static_cast<std::ptrdiff_t>(row) * stride_;
  const double width = window_.width, dy = y1 - y0;
  const double left = std::min(x0, x1), right = std::max(x0, x1);
  const auto add = [&](int pixel, double cover, double middle) {
    // `middle`: mean place of the piece within the pixel, 0 left to 1 right.
    change[pixel] += static_cast<float>(cover * (1 - middle));
    change[pixel + 1] += static_cast<float>(cover * middle);
  };
  if (right <= 0) return add(0, dy, 0);
  if (left >= width) return;
  if (right - left < 1e-12) {
    const int pixel = std::min(static_cast<int>(left), window_.width - 1);
    return add(pixel, dy, left - pixel);
  }
  const double per_x = dy / (right - left);
  if (left < 0) add(0, -left * per_x, 0);
  const double end = std::min(right, width);
  for (double x = std::max(left, 0.0); x < end;) {
    const int pixel = std::min(static_cast<int>(x), window_.width - 1);
    const double next = std::min(end, pixel + 1.0);
    add(pixel, (next - x) * per_x, 0.5 * (x + next) - pixel);
    x = next;
  }
}

void Coverage::Resolve(cv::Mat& alpha) const {
  alpha.create(window_.height, window_.width, CV_32F);
  for (int row = 0; row < window_.height; ++row) {
    const float* change = change_.data() + static_cast<std::ptrdiff_t>(row) * stride_;
    auto* out = alpha.ptr<float>(row);
    float sum = 0;
    for (int x = 0; x < window_.width; ++x) {
      sum += change[x];
      out[x] = std::min(std::abs(sum), 1.0F);
    }
  }
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

}  // namespace palpate::site
