#include "slave/vision/depth/depth_points.h"

#include <algorithm>
#include <cmath>
#include <exception>
#include <limits>
#include <stdexcept>
#include <string>
#include <utility>

#include <Eigen/LU>

#include "shared/text/text.h"

namespace palpate {
namespace {

double Miss(const Eigen::Vector3d& plane, const Eigen::Vector3d& sample) {
  return sample[2] - plane[0] * sample[0] - plane[1] * sample[1] - plane[2];
}

// Fits a plane by least squares; nullopt: fewer samples than `least`, or nearly collinear ones.
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

DepthPoints::Params Checked(const DepthPoints::Params& params) {
  const DepthImages& camera = params.camera;
  for (const auto& [name, value] : {std::pair{"fx", camera.fx},
                                    {"fy", camera.fy},
                                    {"unit", camera.unit},
                                    {"sigma", camera.sigma},
                                    {"correlation", params.correlation}}) {
    Require(value > 0 && std::isfinite(value), name, value, "> 0");
  }
  Require(std::isfinite(camera.cx), "cx", camera.cx, "a number");
  Require(std::isfinite(camera.cy), "cy", camera.cy, "a number");
  if (!camera.X_SD.matrix().allFinite()) {
    throw std::invalid_argument("pose: expected a finite pose");
  }
  Require(params.cell >= 2 && params.cell <= 1024, "cell", 1.0 * params.cell, "2 to 1024 px");
  Require(params.rest_images >= 1 && params.rest_images <= 10000, "rest_images",
          1.0 * params.rest_images, "1 to 10000");
  Require(params.min_full > 0 && params.min_full <= 1, "min_full", params.min_full,
          "0 < share <= 1");
  Require(params.nearest >= 0, "nearest", params.nearest, ">= 0 m");
  Require(params.farthest > params.nearest, "farthest", params.farthest, "> nearest");
  return params;
}

RestDepth MakeRest(const DepthPoints::Params& params) {
  const double unit = params.camera.unit;
  // The largest count marks a pixel without depth [counts]. [by definition]
  constexpr double kMaxCount = std::numeric_limits<std::uint16_t>::max() - 1;
  const double lowest = std::max(1.0, std::ceil(params.nearest / unit));
  const double highest = std::min(kMaxCount, std::floor(params.farthest / unit));
  Require(lowest <= highest, "nearest", params.nearest,
          "less than the largest depth of an image, " + std::to_string(kMaxCount * unit) + " m");
  // A pixel at the edge of a hole or of the object jumps by many sigma from image to image.
  constexpr double kFlicker = 12;  // [sigma]
  return {params.rest_images, static_cast<int>(lowest), static_cast<int>(highest),
          std::max(1.0, kFlicker * params.camera.sigma / unit)};
}

}  // namespace

RestDepth::RestDepth(int images, int lowest, int highest, double flicker)
    : images_(images), lowest_(lowest), highest_(highest), flicker_(flicker) {}

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
    min_count_.assign(pixels, std::numeric_limits<std::uint16_t>::max());
    max_count_.assign(pixels, 0);
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
      min_count_[at] = std::min(min_count_[at], counts[u]);
      max_count_[at] = std::max(max_count_[at], counts[u]);
    }
  }
  if (!any) {
    if (taken_ == 0) Reset();
    return false;
  }
  if (++taken_ == images_) Finish();
  return true;
}

void RestDepth::Finish() {
  for (std::size_t at = 0; at < rest_.size(); ++at) {
    const bool steady =
        2 * seen_[at] > images_ && max_count_[at] - min_count_[at] <= static_cast<int>(flicker_);
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
  // Position relative to the centre in widths of the cell, and 1/z.
  std::vector<Eigen::Vector3d> samples;
  for (int v = cell.row; v < cell.row + cell.edge; ++v) {
    for (int u = cell.column; u < cell.column + cell.edge; ++u) {
      const std::int32_t z = row(v)[u];
      if (z == 0) continue;
      const double x = (u - camera.cx) / camera.fx - x_middle;
      const double y = (v - camera.cy) / camera.fy - y_middle;
      samples.emplace_back(x * camera.fx / cell.edge, y * camera.fy / cell.edge, 1 / (z * metre));
    }
  }
  // Fits twice. Pixels that deviate from the first plane are left out of the second fit.
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

CellShift::CellShift(int edge, double sigma)
    : sigma_(sigma * RestDepth::kFractions),
      changes_(static_cast<std::size_t>(edge) * static_cast<std::size_t>(edge)),
      sample_(changes_.size()) {}

std::optional<CellShift::Mean> CellShift::Of(const cv::Mat& depth, const RestDepth& rest,
                                             const DepthCell& cell, int least) noexcept {
  auto end = changes_.begin();
  for (int v = cell.row; v < cell.row + cell.edge; ++v) {
    const auto* counts = depth.ptr<std::uint16_t>(v);
    const std::int32_t* at_rest = rest.row(v);
    for (int u = cell.column; u < cell.column + cell.edge; ++u) {
      if (at_rest[u] == 0 || !rest.IsMeasured(counts[u])) continue;
      *end++ = RestDepth::kFractions * counts[u] - at_rest[u];
    }
  }
  const auto begin = changes_.begin();
  const auto count = end - begin;
  if (count < std::max(1, least)) return std::nullopt;
  // The median is only a start value, so a third of the pixels, distributed over all rows and
  // columns, is sufficient.
  constexpr std::ptrdiff_t kPlenty = 128;
  const std::ptrdiff_t step = count >= kPlenty ? 3 : 1;
  const auto first = sample_.begin();
  auto last = first;
  for (std::ptrdiff_t i = 0; i < count; i += step) *last++ = begin[i];
  const auto median = first + (last - first) / 2;
  std::nth_element(first, median, last);
  const auto lower = first + (last - first) / 4;
  const auto upper = first + 3 * (last - first) / 4;
  if (lower < median) std::nth_element(first, lower, median);
  if (median < upper) std::nth_element(median + 1, upper, last);
  // Estimates the standard deviation of a normal distribution from both quartiles, or from the
  // closer one if outliers affect the other.
  const double both = 0.7413 * (*upper - *lower);
  const double closer = 1.4826 * std::min(*median - *lower, *upper - *median);
  const double width = 3 * std::max(sigma_, std::min(both, closer + 2 * sigma_));
  double sum = 0;
  double squares = 0;
  int used = 0;
  for (auto it = begin; it != end; ++it) {
    const double off = *it - *median;
    const double near = std::abs(off) <= width ? 1 : 0;
    sum += near * off;
    squares += near * off * off;
    used += near != 0 ? 1 : 0;
  }
  const double mean = sum / used;
  return Mean{(*median + mean) / RestDepth::kFractions,
              std::sqrt(std::max(0.0, squares / used - mean * mean)) / RestDepth::kFractions,
              static_cast<int>(count)};
}

DepthPoints::DepthPoints(const Params& params)
    : params_(Checked(params)),
      rest_(MakeRest(params_)),
      shift_(params_.cell, params_.camera.sigma / params_.camera.unit) {}

void DepthPoints::Reset() noexcept {
  rest_.Reset();
  cells_.clear();
  observation_.points.clear();
  observation_.found = false;
}

const SurfaceObservation& DepthPoints::Observe(const cv::Mat& depth) noexcept try {
  observation_.found = false;
  for (SurfacePoint& point : observation_.points) point.seen = false;
  if (!rest_.known()) {
    if (rest_.Add(depth) && rest_.known()) MakeCells();
    return observation_;
  }
  if (!rest_.Fits(depth)) return observation_;
  std::size_t seen = 0;
  for (std::size_t i = 0; i < cells_.size(); ++i) {
    Measure(depth, cells_[i], &observation_.points[i]);
    seen += observation_.points[i].seen ? 1 : 0;
  }
  observation_.found = seen >= 3 && 10 * seen >= cells_.size();
  return observation_;
} catch (const std::exception&) {  // out of memory for the rest frame
  Reset();
  return observation_;
}

void DepthPoints::MakeCells() {
  const DepthImages& camera = params_.camera;
  const int edge = params_.cell;
  const int columns = rest_.width() / edge;
  const int least = static_cast<int>(std::ceil(params_.min_full * edge * edge));
  for (int k = 0; k < columns * (rest_.height() / edge); ++k) {
    const DepthCell square{k % columns * edge, k / columns * edge, edge};
    const auto plane =
        rest_.PlaneOf(square, least, {camera.fx, camera.fy, camera.cx, camera.cy}, camera.unit);
    if (!plane) continue;
    Cell cell{.square = square,
              .middle = {square.column + 0.5 * (edge - 1), square.row + 0.5 * (edge - 1)}};
    const Eigen::Vector3d ray_D((cell.middle.x() - camera.cx) / camera.fx,
                                (cell.middle.y() - camera.cy) / camera.fy, 1);
    const double inverse_depth = plane->dot(ray_D);
    if (!(inverse_depth > 0)) continue;
    // In 1/z = m . ray the vector m is normal to the plane and points away.
    cell.n_S = -(camera.X_SD.linear() * plane->normalized());
    cell.ray_S = camera.X_SD.linear() * ray_D;
    cell.cosine = -cell.n_S.dot(cell.ray_S);
    // Uniform distribution in the cell: edge / sqrt(12), enlarged by the slant.
    const double side = edge / std::sqrt(12.0 * camera.fx * camera.fy) / inverse_depth;
    const double along = side / std::max(0.1, cell.cosine / ray_D.norm());
    cell.along_S = along * along * (Eigen::Matrix3d::Identity() - cell.n_S * cell.n_S.transpose());
    cells_.push_back(cell);
    SurfacePoint point{.id = k};
    point.p_S_rest = point.p_S = camera.X_SD * (ray_D / inverse_depth);
    observation_.points.push_back(point);
  }
  if (cells_.size() < 3) Reset();
}

void DepthPoints::Measure(const cv::Mat& depth, const Cell& cell, SurfacePoint* point) noexcept {
  const int edge = params_.cell;
  const auto mean = shift_.Of(depth, rest_, cell.square,
                              static_cast<int>(std::ceil(params_.min_full * edge * edge)));
  point->seen = mean.has_value();
  if (!mean) return;
  const double unit = params_.camera.unit;
  point->p_S = point->p_S_rest + cell.ray_S * (mean->shift * unit);
  const double independent =
      std::max(1.0, mean->count / (params_.correlation * params_.correlation));
  // The baseline also has an error, which the scatter of the changes includes.
  const double sigma = params_.camera.sigma * std::sqrt(1 + 1.0 / params_.rest_images);
  const double along_normal = cell.cosine * std::max(sigma, mean->spread * unit);
  const double variance = along_normal * along_normal / independent;
  point->covariance = cell.along_S + variance * cell.n_S * cell.n_S.transpose();
}

}  // namespace palpate
