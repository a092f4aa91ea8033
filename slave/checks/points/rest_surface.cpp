#include "slave/checks/points/rest_surface.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <cstdint>
#include <exception>
#include <limits>
#include <numeric>
#include <span>
#include <utility>

#include <Eigen/Cholesky>

#include "slave/checks/points/points_limits.h"
#include "slave/mesh/index.h"
#include "slave/statistics/robust.h"

namespace palpate {
namespace {

using Eigen::Vector2d;
using Eigen::Vector3d;

constexpr double kNone = std::numeric_limits<double>::infinity();
constexpr std::size_t kMinRays = 6;
constexpr double kMaxRays = 4000;  // of an image
// Width of the edge region relative to the body's half width in the image.
constexpr double kEdgeShare = 0.2;
constexpr std::size_t kMinSide = 8;  // smallest number of rays on one side of the edge

// The depth at which each ray meets the surface first; kNone: it does not.
std::vector<double> ExpectedDepths(const SurfaceMesh& surface_C, const std::vector<RestRay>& rays) {
  std::vector<double> depth(rays.size(), kNone);
  std::vector<std::size_t> order(rays.size());
  std::iota(order.begin(), order.end(), std::size_t{0});
  const auto x_of = [&](std::size_t i) { return rays[i].slope.x(); };
  std::ranges::sort(order, {}, x_of);
  for (const auto& corners : surface_C.triangles) {
    std::array<Vector2d, 3> s;
    Vector3d inverse;
    bool in_front = true;
    for (std::size_t c = 0; c < 3; ++c) {
      const Vector3d& p = surface_C.nodes[Index(corners[c])];
      in_front = in_front && p.z() > 0;
      s[c] = p.head<2>() / p.z();
      inverse[static_cast<Eigen::Index>(c)] = 1 / p.z();
    }
    if (!in_front) continue;
    const Vector2d a = s[1] - s[0], b = s[2] - s[0];
    const double area = a.x() * b.y() - a.y() * b.x();
    if (area == 0) continue;
    const auto [low, high] = std::minmax({s[0].x(), s[1].x(), s[2].x()});
    for (auto at = std::ranges::lower_bound(order, low, {}, x_of);
         at != order.end() && x_of(*at) <= high; ++at) {
      const Vector2d r = rays[*at].slope - s[0];
      const double v = (r.x() * b.y() - r.y() * b.x()) / area;
      const double w = (a.x() * r.y() - a.y() * r.x()) / area;
      if (v < 0 || w < 0 || v + w > 1) continue;
      const double z = 1 / inverse.dot(Vector3d(1 - v - w, v, w));
      depth[*at] = std::min(depth[*at], z);
    }
  }
  return depth;
}

// Least squares of y = c . (x, y, 1); nullopt: too few, or on a line.
std::optional<Vector3d> FitPlane(const std::vector<Vector3d>& samples) {
  if (samples.size() < kMinRays) return std::nullopt;
  Eigen::Matrix3d moments = Eigen::Matrix3d::Zero();
  Vector3d right = Vector3d::Zero();
  for (const Vector3d& s : samples) {
    const Vector3d a(s[0], s[1], 1);
    moments += a * a.transpose();
    right += a * s[2];
  }
  const Eigen::LDLT<Eigen::Matrix3d> factor(moments);
  const Vector3d plane = factor.solve(right);
  if (factor.info() != Eigen::Success || !plane.allFinite()) return std::nullopt;
  return plane;
}

// Returns the distance of each ray to the nearest ray with `is_source`, in steps on the grid, up to
// `most`.
std::vector<int> StepsFrom(const std::vector<char>& is_source, int columns, int most) {
  std::vector<int> steps(is_source.size(), most + 1);
  std::vector<std::size_t> front;
  for (std::size_t i = 0; i < is_source.size(); ++i) {
    if (is_source[i] == 0) continue;
    steps[i] = 0;
    front.push_back(i);
  }
  const auto width = static_cast<std::size_t>(columns);
  for (int step = 1; step <= most && !front.empty(); ++step) {
    std::vector<std::size_t> next;
    const auto visit = [&](std::size_t i) {
      if (steps[i] <= step) return;
      steps[i] = step;
      next.push_back(i);
    };
    for (const std::size_t i : front) {
      if (i % width > 0) visit(i - 1);
      if (i % width + 1 < width) visit(i + 1);
      if (i >= width) visit(i - width);
      if (i + width < is_source.size()) visit(i + width);
    }
    front = std::move(next);
  }
  return steps;
}

struct Count {
  std::size_t all = 0, seen = 0;
  void Add(bool is_seen) {
    ++all;
    seen += is_seen ? 1 : 0;
  }
  [[nodiscard]] double share() const {
    return all > 0 ? static_cast<double>(seen) / static_cast<double>(all) : 0;
  }
};

// Compares the depths of the rays along the body's edge. `gate`: largest deviation of a depth on
// the surface [m]; `shift`: measured minus expected distance there.
void CompareEdge(const std::vector<RestRay>& rays, const std::vector<double>& expected, int columns,
                 double gate, const auto& shift, RestSurface* rest) {
  std::vector<char> hits(rays.size()), misses(rays.size());
  Vector2d middle = Vector2d::Zero();
  std::vector<Vector3d> inverse;
  for (std::size_t i = 0; i < rays.size(); ++i) {
    hits[i] = expected[i] < kNone ? 1 : 0;
    misses[i] = hits[i] != 0 ? 0 : 1;
    if (hits[i] == 0) continue;
    middle += rays[i].slope;
    inverse.emplace_back(rays[i].slope.x(), rays[i].slope.y(), 1 / expected[i]);
  }
  const auto count = static_cast<double>(inverse.size());
  middle /= count;
  const int width = std::max(2, static_cast<int>(std::lround(kEdgeShare * std::sqrt(count) / 2)));
  const std::vector<int> inside = StepsFrom(misses, columns, width);
  const std::vector<int> outside = StepsFrom(hits, columns, width);
  const auto plane = FitPlane(inverse);
  const bool is_flat =
      plane && std::ranges::all_of(inverse, [&](const Vector3d& s) {
        return std::abs(plane->dot(Vector3d(s[0], s[1], 1)) / s[2] - 1) < PointsLimits::kTrueSize;
      });
  Count core;
  std::array<Count, 4> edge, beyond;
  for (std::size_t i = 0; i < rays.size(); ++i) {
    const Vector2d d = rays[i].slope - middle;
    const std::size_t side =
        std::abs(d.x()) > std::abs(d.y()) ? (d.x() > 0 ? 0 : 1) : (d.y() > 0 ? 2 : 3);
    const auto sees = [&](double z) {
      return rays[i].z > 0 && std::abs(rays[i].z - z - shift(rays[i])) <= gate;
    };
    if (hits[i] != 0) {
      (inside[i] > width ? core : edge[side]).Add(sees(expected[i]));
    } else if (is_flat && outside[i] <= width) {
      const double inverse_z = plane->dot(Vector3d(rays[i].slope.x(), rays[i].slope.y(), 1));
      beyond[side].Add(inverse_z > 0 && sees(1 / inverse_z));
    }
  }
  if (core.seen < kMinRays) return;
  for (const Count& side : edge) {
    if (side.all >= kMinSide) rest->edge = std::min(rest->edge, side.share() / core.share());
  }
  // Both sides along an axis must show it, because another body may be beside this one.
  for (const std::size_t axis : {std::size_t{0}, std::size_t{2}}) {
    const Count &one = beyond[axis], &other = beyond[axis + 1];
    if (one.all < kMinSide || other.all < kMinSide) continue;
    rest->beyond = std::max(rest->beyond, std::min(one.share(), other.share()) / core.share());
  }
}

}  // namespace

RestSurface CompareAtRest(const SurfaceMesh& surface_C, const std::vector<RestRay>& rays,
                          int columns, double sigma, double independent) {
  RestSurface rest;
  rest.meets = rays.size() < kMinRays;  // a few points show nothing
  if (rest.meets) return rest;
  const std::vector<double> expected = ExpectedDepths(surface_C, rays);
  std::vector<double> off, depths;
  for (std::size_t i = 0; i < rays.size(); ++i) {
    if (expected[i] == kNone) continue;
    depths.push_back(expected[i]);
    if (rays[i].z > 0) off.push_back(rays[i].z - expected[i]);
  }
  constexpr double kMinSeen = 0.1;  // of the rays that meet the body
  if (off.size() < kMinRays ||
      static_cast<double>(off.size()) < kMinSeen * static_cast<double>(depths.size())) {
    return rest;
  }
  rest.meets = true;
  rest.distance = MedianOf(depths);
  const double median = MedianOf(off);
  for (double& d : off) d = std::abs(d - median);
  constexpr double kNormal = 1.4826, kWidth = 3;  // [derived: sigma by the median of a normal]
  const double gate = kWidth * std::max(kNormal * MedianOf(off), sigma);
  std::vector<Vector3d> samples;  // position across the axis [m], excess distance [m]
  Vector2d middle = Vector2d::Zero();
  for (std::size_t i = 0; i < rays.size(); ++i) {
    const bool is_near =
        expected[i] < kNone && rays[i].z > 0 && std::abs(rays[i].z - expected[i] - median) <= gate;
    if (!is_near) continue;
    const Vector2d place = rest.distance * rays[i].slope;
    samples.emplace_back(place.x(), place.y(), rays[i].z - expected[i]);
    middle += place;
  }
  const auto count = static_cast<double>(samples.size());
  middle /= count;
  for (Vector3d& s : samples) s.head<2>() -= middle;
  const auto plane = FitPlane(samples);
  if (!plane) return rest;
  double residual = 0, spread = 0;
  for (const Vector3d& s : samples) {
    const double miss = s[2] - plane->dot(Vector3d(s[0], s[1], 1));
    residual += miss * miss / count;
    spread += s.head<2>().squaredNorm() / 2 / count;
  }
  const double of_mean = std::sqrt(residual / std::max(1.0, count / independent));
  rest.off = (*plane)[2];
  rest.sigma_off = of_mean;
  rest.tilt = std::atan(plane->head<2>().norm());
  rest.sigma_tilt = of_mean / std::sqrt(spread);
  if (columns > 0) {
    const auto shift = [&](const RestRay& ray) {
      const Vector2d place = rest.distance * ray.slope - middle;
      return plane->dot(Vector3d(place.x(), place.y(), 1));
    };
    const double near = std::max(gate, PointsLimits::kTrueSize * rest.distance);
    CompareEdge(rays, expected, columns, near, shift, &rest);
  }
  return rest;
}

std::string_view FaultOf(const RestSurface& rest, double size) {
  const auto exceeds = [](double value, double sigma, double most) {
    return std::abs(value) > std::max(most, PointsLimits::kRestSigmas * sigma);
  };
  if (!rest.meets) {
    return "the camera sees no surface at rest where the scene has the body: check the pose, fx, "
           "fy, "
           "cx, cy and unit";
  }
  const double most =
      std::min(PointsLimits::kTrueSize * rest.distance, PointsLimits::kRestOffset * size);
  if (exceeds(rest.off, rest.sigma_off, most)) {
    return "the surface at rest is nearer or farther than in the scene: check unit, baseline, fx, "
           "fy "
           "and the poses";
  }
  if (rest.edge < PointsLimits::kRestEdge) {
    return "the surface at rest does not extend as far as in the scene: check fx, fy, cx, cy for "
           "this "
           "image size, and the poses";
  }
  if (rest.beyond > 1 - PointsLimits::kRestEdge) {
    return "the surface at rest extends farther than in the scene: check fx, fy for this image "
           "size, "
           "and what is beside the body";
  }
  if (exceeds(rest.tilt, rest.sigma_tilt, PointsLimits::kRestTilt)) {
    return "the surface at rest is tilted against the scene: check the rotations of the poses";
  }
  return {};
}

RestSurfaceCheck::RestSurfaceCheck(const Scene& scene, SurfaceMesh surface_O,
                                   std::optional<RestSurface>* result)
    : surface_C_(std::move(surface_O)), result_(result) {
  const auto* depth = scene.sense.Find<DepthImages>();
  if (depth != nullptr) depth_ = *depth;
  X_CS_ = (depth != nullptr ? depth->X_SD : scene.sense.Find<StereoCameras>()->X_SL).inverse();
  Eigen::AlignedBox3d box;
  for (Vector3d& p : surface_C_.nodes) {
    box.extend(p);
    p = X_CS_ * scene.object.X_SO * p;
  }
  size_ = box.sizes().maxCoeff();
}

void RestSurfaceCheck::Examine(const PointsSample& sample, Findings* findings) noexcept try {
  if (!sample.seen.found) return;
  if (!*result_) {
    std::vector<RestRay> rays;
    int columns = 0;
    double sigma = 0, independent = 1;
    if (depth_) {
      const cv::Mat& image = sample.left;
      if (image.type() != CV_16UC1) return;
      const int step =
          std::max(1, static_cast<int>(std::ceil(std::sqrt(image.cols * image.rows / kMaxRays))));
      columns = (image.cols + step - 1) / step;
      for (int v = 0; v < image.rows; v += step) {
        const auto* counts = image.ptr<std::uint16_t>(v);
        for (int u = 0; u < image.cols; u += step) {
          const bool is_none = counts[u] == std::numeric_limits<std::uint16_t>::max();
          rays.push_back({{(u - depth_->cx) / depth_->fx, (v - depth_->cy) / depth_->fy},
                          is_none ? 0 : counts[u] * depth_->unit});
        }
      }
      sigma = depth_->sigma;
      const double patch = PointsLimits::kDepthPatch / step;
      independent = std::max(1.0, patch * patch);
    } else {
      for (const SurfacePoint& point : sample.seen.points) {
        const Vector3d p_C = X_CS_ * point.p_S_rest;
        if (point.seen && p_C.z() > 0) rays.push_back({p_C.head<2>() / p_C.z(), p_C.z()});
      }
    }
    *result_ = CompareAtRest(surface_C_, rays, columns, sigma, independent);
    (*result_)->fault = FaultOf(**result_, size_);
  }
  if (!(*result_)->fault.empty()) findings->Fail(FailedCheck::kRestShape, (*result_)->fault);
} catch (const std::exception&) {  // out of memory: repeated with the next image
  result_->reset();
}

}  // namespace palpate
