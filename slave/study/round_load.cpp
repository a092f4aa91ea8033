#include "slave/study/round_load.h"

#include <algorithm>
#include <array>

#include <Eigen/Geometry>

#include "shared/mesh/surface_patch.h"

namespace palpate::study {
namespace {

using Eigen::Matrix3d;
using Eigen::Vector3d;

constexpr int kDepth = 6;          // halvings of an edge
constexpr double kSameSide = 0.5;  // cosine between normals, as in contact patches

// One triangle and the ball that cuts it.
class Cut {
 public:
  // `corners`: columns; `area` [m^2].
  Cut(const Matrix3d& corners, double area, const Vector3d& centre, double radius)
      : corners_(corners), centre_(centre), radius_(radius) {
    Add(Matrix3d::Identity(), area, 0);
  }
  // Integral of l l^T, l the barycentric coordinates, over what lies in the ball [m^2]. The sum of
  // all entries is the area, since coordinates sum up to 1.
  [[nodiscard]] const Matrix3d& moment() const { return moment_; }

 private:
  // `piece`: its corners' coordinates as columns.
  void Add(const Matrix3d& piece, double area, int depth) {
    const Vector3d middle = piece.rowwise().mean();
    double reach = 0;
    bool whole = true;
    for (int i = 0; i < 3; ++i) {
      reach = std::max(reach, (corners_ * (piece.col(i) - middle)).norm());
      whole = whole && Distance(piece.col(i)) <= radius_;
    }
    const double distance = Distance(middle);
    if (distance > radius_ + reach) return;
    Matrix3d middles;  // of the edges
    for (int i = 0; i < 3; ++i) middles.col(i) = 0.5 * (piece.col(i) + piece.col((i + 1) % 3));
    if (!whole && depth < kDepth) {
      for (int i = 0; i < 3; ++i) {
        Matrix3d quarter;
        quarter << piece.col(i), middles.col(i), middles.col((i + 2) % 3);
        Add(quarter, area / 4, depth + 1);
      }
      Add(middles, area / 4, depth + 1);
    } else if (whole || distance <= radius_) {
      moment_ += area / 3 * middles * middles.transpose();  // exact: l l^T is quadratic
    }
  }
  [[nodiscard]] double Distance(const Vector3d& l) const { return (corners_ * l - centre_).norm(); }

  const Matrix3d& corners_;
  const Vector3d& centre_;
  double radius_;
  Matrix3d moment_ = Matrix3d::Zero();
};

}  // namespace

std::vector<LoadPoint> RoundLoad(const SurfaceMesh& surface, const Vector3d& p_O,
                                 const Vector3d& inward_O, double width, bool quadratic) {
  std::vector<LoadPoint> points;
  double total = 0;
  for (int t = 0; t < static_cast<int>(surface.triangles.size()); ++t) {
    if (-Normal(surface, t).dot(inward_O) < kSameSide) continue;
    Matrix3d corners;
    for (int i = 0; i < 3; ++i) {
      const auto& nodes = surface.triangles[static_cast<std::size_t>(t)];
      corners.col(i) = surface.nodes[static_cast<std::size_t>(nodes[static_cast<std::size_t>(i)])];
    }
    const Matrix3d m = Cut(corners, Area(surface, t), p_O, 0.5 * width).moment();
    const double area = m.sum();
    if (!(area > 0)) continue;
    total += area;
    const Vector3d first = m.rowwise().sum();
    if (!quadratic) points.push_back({corners * first / area, t, area});
    for (int i = 0; quadratic && i < 3; ++i) {
      const int j = (i + 1) % 3;
      points.push_back({corners.col(i), t, 2 * m(i, i) - first[i]});
      points.push_back({0.5 * (corners.col(i) + corners.col(j)), t, 4 * m(i, j)});
    }
  }
  for (LoadPoint& point : points) point.share /= total;
  return points;
}

}  // namespace palpate::study
