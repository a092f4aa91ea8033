#include "slave/vision/depth/rest_depth.h"

#include <algorithm>
#include <cmath>
#include <limits>

#include <Eigen/LU>

namespace palpate {
namespace {

double Miss(const Eigen::Vector3d& plane, const Eigen::Vector3d& sample) {
  return sample[2] - plane[0] * sample[0] - plane[1] * sample[1] - plane[2];
}

// Least squares; nullopt: fewer samples than `least`, or all about on a line.
std::optional<Eigen::Vector3d> FitPlane(const std::vector<Eigen::Vector3d>& samples, int least) {
  const auto count = static_cast<double>(samples.size());
  if (count < std::max(3, least)) return std::nullopt;
  Eigen::Matrix3d moments = Eigen::Matrix3d::Zero();
  Eigen::Vector3d right = Eigen::Vector3d::Zero();
  for (const Eigen::Vector3d& s : samples) {
    const Eigen::Vector3d a(s[0], s[1], 1);
    moments += a * a.transpose() / count;
    right += a * (s[2] / count);
  }
  // A full cell's determinant is 1 / 144.
  if (!(moments.determinant() > 1e-5)) return std::nullopt;
  return moments.inverse() * right;
}

}  // namespace

RestDepth::RestDepth(int pictures, int lowest, int highest, double flicker)
    : pictures_(pictures), lowest_(lowest), highest_(highest), flicker_(flicker) {}

bool RestDepth::Fits(const cv::Mat& depth) const noexcept {
  return depth.dims == 2 && depth.type() == CV_16UC1 && depth.data != nullptr && depth.cols > 0 &&
         depth.rows > 0 && (width_ == 0 || (depth.cols == width_ && depth.rows == height_));
}

bool RestDepth::Add(const cv::Mat& depth) {
  if (known() || !Fits(depth)) return false;
  if (taken_ == 0) {
    width_ = depth.cols;
    height_ = depth.rows;
    const auto pixels = static_cast<std::size_t>(width_) * static_cast<std::size_t>(height_);
    rest_.assign(pixels, 0);
    seen_.assign(pixels, 0);
    least_.assign(pixels, std::numeric_limits<std::uint16_t>::max());
    most_.assign(pixels, 0);
  }
  bool any = false;
  for (int v = 0; v < height_; ++v) {
    const auto* counts = depth.ptr<std::uint16_t>(v);
    auto at = static_cast<std::size_t>(v) * static_cast<std::size_t>(width_);
    for (int u = 0; u < width_; ++u, ++at) {
      if (!IsMeasured(counts[u])) continue;
      any = true;
      rest_[at] += counts[u];
      ++seen_[at];
      least_[at] = std::min(least_[at], counts[u]);
      most_[at] = std::max(most_[at], counts[u]);
    }
  }
  if (!any) {
    if (taken_ == 0) Reset();
    return false;
  }
  if (++taken_ == pictures_) Finish();
  return true;
}

void RestDepth::Finish() {
  for (std::size_t at = 0; at < rest_.size(); ++at) {
    const bool steady =
        2 * seen_[at] > pictures_ && most_[at] - least_[at] <= static_cast<int>(flicker_);
    const double mean = steady ? static_cast<double>(rest_[at]) / seen_[at] : 0;
    rest_[at] = static_cast<std::int32_t>(std::lround(kFractions * mean));
  }
}

void RestDepth::Reset() noexcept {
  width_ = height_ = taken_ = 0;
}

std::optional<InverseDepth> RestDepth::PlaneOf(const DepthCell& cell, int least,
                                               const Pinhole& camera, double unit) const {
  const double metre = unit / kFractions;
  const double x_middle = (cell.column + 0.5 * (cell.edge - 1) - camera.cx) / camera.fx;
  const double y_middle = (cell.row + 0.5 * (cell.edge - 1) - camera.cy) / camera.fy;
  std::vector<Eigen::Vector3d> samples;  // in widths of the cell from its middle, and 1/z
  for (int v = cell.row; v < cell.row + cell.edge; ++v) {
    for (int u = cell.column; u < cell.column + cell.edge; ++u) {
      const std::int32_t z = row(v)[u];
      if (z == 0) continue;
      const double x = (u - camera.cx) / camera.fx - x_middle;
      const double y = (v - camera.cy) / camera.fy - y_middle;
      samples.emplace_back(x * camera.fx / cell.edge, y * camera.fy / cell.edge, 1 / (z * metre));
    }
  }
  // Twice: what stands out of the first plane takes no part in the second.
  std::optional<Eigen::Vector3d> plane = FitPlane(samples, least);
  if (!plane) return std::nullopt;
  double mean_miss = 0;
  for (const Eigen::Vector3d& s : samples) mean_miss += std::abs(Miss(*plane, s));
  mean_miss /= static_cast<double>(samples.size());
  std::erase_if(samples, [&](const auto& s) { return std::abs(Miss(*plane, s)) > 3 * mean_miss; });
  plane = FitPlane(samples, least);
  if (!plane) return std::nullopt;
  const double m_x = (*plane)[0] * camera.fx / cell.edge;
  const double m_y = (*plane)[1] * camera.fy / cell.edge;
  return InverseDepth(m_x, m_y, (*plane)[2] - m_x * x_middle - m_y * y_middle);
}

}  // namespace palpate
