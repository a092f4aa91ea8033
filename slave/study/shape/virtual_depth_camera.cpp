#include "slave/study/shape/virtual_depth_camera.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <limits>
#include <random>

namespace palpate::study {
namespace {

using Eigen::Vector3d;

constexpr double kNearest = 1e-4;  // smallest visible depth [m]
constexpr double kNothing = std::numeric_limits<double>::infinity();

// Distances along the rays in units of z_D: a hit at depth z is at z times the ray.
class DepthImage {
 public:
  explicit DepthImage(const DepthCamera& camera)
      : width_(std::max(0, camera.size[0])),
        height_(std::max(0, camera.size[1])),
        focal_(camera.focal),
        depth_(static_cast<std::size_t>(width_) * static_cast<std::size_t>(height_), kNothing) {}

  [[nodiscard]] Vector3d Ray(int u, int v) const {
    return {(u + 0.5 - 0.5 * width_) / focal_, (v + 0.5 - 0.5 * height_) / focal_, 1};
  }
  [[nodiscard]] int width() const { return width_; }
  [[nodiscard]] int height() const { return height_; }
  [[nodiscard]] double At(int u, int v) const { return depth_[Index(u, v)]; }

  // Every pixel whose ray intersects the triangle stores the nearest hit.
  void Draw(const std::array<Vector3d, 3>& p_D) {
    const Vector3d n = (p_D[1] - p_D[0]).cross(p_D[2] - p_D[0]);
    const double offset = n.dot(p_D[0]);
    // A ray is inside of an edge if it is on one side of the plane through the camera's centre and
    // the edge. Neighbours compute the same plane, so no ray passes between them.
    const std::array<Vector3d, 3> edges{p_D[0].cross(p_D[1]), p_D[1].cross(p_D[2]),
                                        p_D[2].cross(p_D[0])};
    const auto [u0, u1, v0, v1] = PixelsAround(p_D);
    for (int v = v0; v < v1; ++v) {
      for (int u = u0; u < u1; ++u) {
        const Vector3d ray = Ray(u, v);
        const double a = edges[0].dot(ray), b = edges[1].dot(ray), c = edges[2].dot(ray);
        if (!((a >= 0 && b >= 0 && c >= 0) || (a <= 0 && b <= 0 && c <= 0))) continue;
        const double z = offset / n.dot(ray);  // not finite for a triangle parallel to the ray
        double& kept = depth_[Index(u, v)];
        if (z >= kNearest && z < kept) kept = z;
      }
    }
  }

 private:
  [[nodiscard]] std::size_t Index(int u, int v) const {
    return static_cast<std::size_t>(v) * static_cast<std::size_t>(width_) +
           static_cast<std::size_t>(u);
  }

  // u0, u1, v0, v1 of the pixels that may see the triangle, ends excluded: around its corners and
  // where its edges pass the nearest plane.
  [[nodiscard]] std::array<int, 4> PixelsAround(const std::array<Vector3d, 3>& p_D) const {
    Eigen::Array2d low = Eigen::Array2d::Constant(kNothing), high = -low;
    const auto include = [&](const Vector3d& p) {
      const Eigen::Array2d at =
          focal_ * p.head<2>().array() / p.z() + 0.5 * Eigen::Array2d(width_, height_);
      low = low.min(at);
      high = high.max(at);
    };
    for (std::size_t i = 0; i < 3; ++i) {
      const Vector3d &a = p_D[i], &b = p_D[(i + 1) % 3];
      if (a.z() >= kNearest) include(a);
      if ((a.z() < kNearest) != (b.z() < kNearest)) {
        Vector3d p = a + (kNearest - a.z()) / (b.z() - a.z()) * (b - a);
        p.z() = kNearest;
        include(p);
      }
    }
    const auto pixel = [](double at, int size) {
      return static_cast<int>(std::clamp(std::floor(at), 0.0, static_cast<double>(size)));
    };
    // The range is one pixel larger than the corners, for rounding.
    return {pixel(low.x() - 1, width_), pixel(high.x() + 2, width_), pixel(low.y() - 1, height_),
            pixel(high.y() + 2, height_)};
  }

  int width_, height_;
  double focal_;
  std::vector<double> depth_;
};

// Returns the first intersection of the ray through the origin with the sphere, in units of `ray`.
double HitSphere(const Vector3d& ray, const Vector3d& centre, double radius) {
  const double a = ray.squaredNorm(), b = ray.dot(centre);
  const double under = b * b - a * (centre.squaredNorm() - radius * radius);
  if (under < 0) return kNothing;
  const double t = (b - std::sqrt(under)) / a;
  return t > 0 ? t : kNothing;
}

// Intersects the ray with a capsule: two spheres and the cylinder between them.
double HitCapsule(const Vector3d& ray, const Occluder& capsule) {
  double nearest = std::min(HitSphere(ray, capsule.a, capsule.radius),
                            HitSphere(ray, capsule.b, capsule.radius));
  const Vector3d axis = capsule.b - capsule.a;
  const double length2 = axis.squaredNorm();
  if (length2 == 0) return nearest;
  // Components perpendicular to the axis.
  const Vector3d d = ray - ray.dot(axis) / length2 * axis;
  const Vector3d c = capsule.a - capsule.a.dot(axis) / length2 * axis;
  if (d.squaredNorm() == 0) return nearest;
  const double t = HitSphere(d, c, capsule.radius);
  const double along = (t * ray - capsule.a).dot(axis);
  if (t < nearest && along >= 0 && along <= length2) nearest = t;
  return nearest;
}

std::vector<Occluder> InFrame(const Eigen::Isometry3d& X_DS, std::span<const Occluder> occluders) {
  std::vector<Occluder> moved;
  for (const Occluder& o : occluders) moved.push_back({X_DS * o.a, X_DS * o.b, o.radius});
  return moved;
}

}  // namespace

std::vector<Vector3d> ScanSurface(const DepthCamera& camera, const SurfaceMesh& surface,
                                  std::span<const Occluder> occluders, std::uint32_t seed) {
  DepthImage image(camera);
  const Eigen::Isometry3d X_DS = camera.X_SD.inverse();
  for (const auto& triangle : surface.triangles) {
    std::array<Vector3d, 3> p_D;
    for (std::size_t i = 0; i < 3; ++i) {
      p_D[i] = X_DS * surface.nodes[static_cast<std::size_t>(triangle[i])];
    }
    if (p_D[0].allFinite() && p_D[1].allFinite() && p_D[2].allFinite()) image.Draw(p_D);
  }
  const std::vector<Occluder> capsules_D = InFrame(X_DS, occluders);
  std::mt19937 generator(seed);
  std::normal_distribution<double> noise(0, 1);
  std::vector<Vector3d> cloud_S;
  for (int v = 0; v < image.height(); ++v) {
    for (int u = 0; u < image.width(); ++u) {
      const double z = image.At(u, v);
      if (z == kNothing) continue;
      const Vector3d ray = image.Ray(u, v);
      const bool hidden = std::ranges::any_of(
          capsules_D, [&](const Occluder& capsule) { return HitCapsule(ray, capsule) < z; });
      // Also drawn for hidden pixels, so that occluders do not change the noise of other pixels.
      const double along = camera.noise * noise(generator);
      if (!hidden) cloud_S.push_back(camera.X_SD * (z * ray + along * ray.normalized()));
    }
  }
  return cloud_S;
}

}  // namespace palpate::study
