// Position and size of a load from the body's Green's functions at rest: three nodal forces of one
// sign along the normal of a triangle form one load between its nodes.
#pragma once

#include <array>
#include <vector>

#include <Eigen/Core>

#include "shared/mesh/solid_mesh.h"
#include "slave/contact/surface_contact.h"
#include "slave/mechanics/deformation_model.h"
#include "slave/mechanics/footprint/contact_footprint.h"
#include "slave/vision/stereo/surface_points.h"

namespace palpate {

// Motion of a body's visible points under a load on any node of its surface: Green's functions by
// reciprocity, from loads on the points. Small strain, at rest. Frame O.
class PointGreens {
 public:
  // `load`: a force small enough for a linear response [N]; `patch`: diameter of the discs over
  // which a node's load is spread [m].
  PointGreens(const SurfaceMesh& surface, double load, double patch);

  // Computes the Green's functions of points whose position at rest differs from the last call, by
  // three Responds each: for as many points as VolumeLimits::kWork permits, visible ones first.
  // Later calls continue. IsSolved() is false for a point without a solution. Allocates if the
  // number of points is new.
  void Update(DeformationModel& model, const SurfaceContact& contact,
              const std::vector<SurfacePoint>& points_O);
  // Share of the visible points for which a solution was attempted [-].
  [[nodiscard]] double done() const { return done_; }
  [[nodiscard]] bool IsSolved(std::size_t point) const { return known_[point]; }
  // Takes the functions of `before`, which has the same surface and patches, multiplied by `scale`,
  // if `model` moves accordingly under loads on one point. Three Responds.
  void TakeOver(PointGreens* before, double scale, DeformationModel& model,
                const SurfaceContact& contact);
  // Nodes that can be loaded.
  [[nodiscard]] const std::vector<int>& nodes() const { return nodes_; }
  // Column per node of nodes(), three rows per point: displacement [m] of the point along x, y and
  // z by a force of 1 N on the node along its axis `axis`.
  [[nodiscard]] const Eigen::MatrixXd& by(int axis) const {
    return by_[static_cast<std::size_t>(axis)];
  }
  // Index of the node in nodes().
  [[nodiscard]] int IndexOf(int node) const { return index_[static_cast<std::size_t>(node)]; }

 private:
  void FindPatches(double patch);
  void Solve(DeformationModel& model, const SurfaceContact& contact, std::size_t point);
  bool Load(DeformationModel& model, const Contact& contact, Eigen::Index row);

  const SurfaceMesh& surface_;
  double load_;
  std::vector<int> nodes_, index_;
  std::vector<std::vector<PlaceWeight>> patches_;  // nodes that share a node's load
  std::vector<Eigen::Vector3d> rest_, field_;
  Solution solution_;
  std::vector<bool> known_;
  double done_ = 0;
  std::array<Eigen::MatrixXd, 3> by_;
};

// Forces at a triangle's nodes, along its normal, that explain the largest part of the motion.
struct TriangleLoad {
  int triangle = -1;                                     // -1: none
  Eigen::Vector3d forces{0, 0, 0};                       // [N]
  Eigen::Matrix3d covariance = Eigen::Matrix3d::Zero();  // [N^2], from that of the points
  double explained = -1;                                 // sum of squares, in sigmas of the points
};

// Least squares in all three components of all points. Frame O.
class TriangleSearch {
 public:
  // Stores a reference to `surface`. `load`, `patch`: see PointGreens.
  TriangleSearch(const SurfaceMesh& surface, double load, double patch);

  // Sets the points for the calls below. New ones are not usable before they are solved, see
  // PointGreens::Update. Allocates if their number is new; may throw std::bad_alloc.
  void Read(DeformationModel& model, const SurfaceContact& contact,
            const std::vector<SurfacePoint>& points_O);
  // Excludes points beyond the scatter; at least VolumeLimits::kMinPoints stay.
  TriangleLoad FindWithoutOutliers() noexcept;
  // Uses the remaining points.
  TriangleLoad Find() noexcept;
  // The next search does not begin at the last load.
  void Forget() noexcept { last_ = -1; }
  // See PointGreens.
  void TakeOver(TriangleSearch* before, double scale, DeformationModel& model,
                const SurfaceContact& contact) {
    greens_.TakeOver(&before->greens_, scale, model, contact);
  }
  [[nodiscard]] double done() const noexcept { return greens_.done(); }

  [[nodiscard]] int usable() const noexcept { return usable_; }
  [[nodiscard]] int kept() const noexcept { return kept_; }
  [[nodiscard]] bool IsKept(std::size_t point) const { return seen_[point].kept; }
  [[nodiscard]] const std::vector<Eigen::Vector3d>& rest() const noexcept { return rest_; }
  [[nodiscard]] const Eigen::Vector3d& normal(int triangle) const {
    return normals_[static_cast<std::size_t>(triangle)];
  }
  // Sum of squared measurements that the best load had to explain, in sigmas.
  [[nodiscard]] double measured() const noexcept { return square_; }
  // Displacement of a point under the load, for small loads on the body at rest [m].
  [[nodiscard]] Eigen::Vector3d Displacement(const TriangleLoad& load,
                                             std::size_t point) const noexcept;
  // Sets a further motion of the point [m], which is subtracted from its displacement until Read.
  void SubtractMotion(std::size_t point, const Eigen::Vector3d& beyond) {
    seen_[point].beyond = beyond;
  }

 private:
  struct Seen {
    Eigen::Vector3d moved{0, 0, 0};   // [m]
    Eigen::Vector3d beyond{0, 0, 0};  // [m]
    Eigen::Matrix3d whitener =
        Eigen::Matrix3d::Zero();  // inverse of the covariance's Cholesky factor
    double residual = 0;          // divided by sigma
    bool usable = false, kept = false;
  };
  void Weigh() noexcept;
  void ShapeOf(Eigen::Index column, const Eigen::Vector3d& n,
               Eigen::VectorXd* shape) const noexcept;
  void SolveAroundTriangle(int triangle, TriangleLoad* best) noexcept;
  void SolveAroundNode(int node, TriangleLoad* best) noexcept;
  void SolveTriangle(int triangle, TriangleLoad* best) noexcept;
  bool ExcludeOutliers(const TriangleLoad& best) noexcept;

  const SurfaceMesh& surface_;
  PointGreens greens_;
  std::vector<Eigen::Vector3d> normals_, node_normals_;
  std::vector<std::vector<int>> around_;  // triangles of each node

  std::vector<Seen> seen_;
  std::vector<Eigen::Vector3d> rest_;
  std::vector<double> sorted_;
  Eigen::VectorXd measured_, shape_, score_;  // divided by sigma
  std::array<Eigen::VectorXd, 3> corner_;     // shapes of a triangle's nodes, divided by sigma
  double square_ = 0;
  int usable_ = 0, kept_ = 0;
  int last_ = -1;  // triangle of the last load; -1: none
};

}  // namespace palpate
