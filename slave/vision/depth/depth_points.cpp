#include "slave/vision/depth/depth_points.h"

#include <algorithm>
#include <cmath>
#include <exception>
#include <limits>
#include <stdexcept>
#include <string>

namespace palpate {
namespace {

void Refuse(const std::string& name, double value, const std::string& accepted) {
  throw std::invalid_argument(name + " = " + std::to_string(value) + ": accepted is " + accepted);
}

DepthPoints::Params Checked(const DepthPoints::Params& params) {
  const DepthPictures& camera = params.camera;
  const auto positive = [](const std::string& name, double value) {
    if (!(value > 0 && std::isfinite(value))) Refuse(name, value, "> 0");
  };
  positive("fx", camera.fx);
  positive("fy", camera.fy);
  if (!std::isfinite(camera.cx)) Refuse("cx", camera.cx, "a number");
  if (!std::isfinite(camera.cy)) Refuse("cy", camera.cy, "a number");
  positive("unit", camera.unit);
  positive("sigma", camera.sigma);
  positive("correlation", params.correlation);
  if (!camera.X_SD.matrix().allFinite()) {
    throw std::invalid_argument("pose: accepted is a finite pose");
  }
  if (params.cell < 2 || params.cell > 1024) Refuse("cell", params.cell, "2 to 1024 px");
  if (params.rest_pictures < 1 || params.rest_pictures > 10000) {
    Refuse("rest_pictures", params.rest_pictures, "1 to 10000");
  }
  if (!(params.least_full > 0 && params.least_full <= 1)) {
    Refuse("least_full", params.least_full, "0 < share <= 1");
  }
  if (!(params.nearest >= 0)) Refuse("nearest", params.nearest, ">= 0 m");
  if (!(params.farthest > params.nearest)) Refuse("farthest", params.farthest, "> nearest");
  return params;
}

RestDepth MakeRest(const DepthPoints::Params& params) {
  const double unit = params.camera.unit;
  // The largest count is no depth: it says that the picture ends there.
  constexpr double kLargest = std::numeric_limits<std::uint16_t>::max() - 1;
  const double lowest = std::max(1.0, std::ceil(params.nearest / unit));
  const double highest = std::min(kLargest, std::floor(params.farthest / unit));
  if (!(lowest <= highest)) {
    Refuse("nearest", params.nearest,
           "below what a picture can tell, " + std::to_string(kLargest * unit) + " m");
  }
  // A pixel at the edge of a hole or of the object jumps by many sigma from picture to picture.
  constexpr double kFlicker = 12;  // [sigma]
  return {params.rest_pictures, static_cast<int>(lowest), static_cast<int>(highest),
          std::max(1.0, kFlicker * params.camera.sigma / unit)};
}

}  // namespace

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

const SurfaceObservation& DepthPoints::Observe(const cv::Mat& depth, std::uint64_t sequence,
                                               Time sensed_at) noexcept try {
  observation_.sequence = sequence;
  observation_.sensed_at = sensed_at;
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
} catch (const std::exception&) {  // no memory for the rest frame
  Reset();
  return observation_;
}

void DepthPoints::MakeCells() {
  const DepthPictures& camera = params_.camera;
  const int edge = params_.cell;
  const int columns = rest_.width() / edge;
  const int least = static_cast<int>(std::ceil(params_.least_full * edge * edge));
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
    // Where 1/z = m . ray along every ray, m is normal to the plane and points away.
    cell.n_S = -(camera.X_SD.linear() * plane->normalized());
    cell.ray_S = camera.X_SD.linear() * ray_D;
    cell.cosine = -cell.n_S.dot(cell.ray_S);
    // Evenly anywhere in the cell: edge / sqrt(12), seen on the slant.
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
                              static_cast<int>(std::ceil(params_.least_full * edge * edge)));
  point->seen = mean.has_value();
  if (!mean) return;
  const double unit = params_.camera.unit;
  point->p_S = point->p_S_rest + cell.ray_S * (mean->shift * unit);
  const double independent =
      std::max(1.0, mean->count / (params_.correlation * params_.correlation));
  // The rest frame errs too; what the changes scatter by has that in it.
  const double sigma = params_.camera.sigma * std::sqrt(1 + 1.0 / params_.rest_pictures);
  const double along_normal = cell.cosine * std::max(sigma, mean->spread * unit);
  const double variance = along_normal * along_normal / independent;
  point->covariance = cell.along_S + variance * cell.n_S * cell.n_S.transpose();
}

}  // namespace palpate
