// An elastic skin without bending stiffness, fixed at its rim, under tension and with air behind
// it: its deformation by small loads, relative to its shape at rest.
//
//   K u = f,   K = E h K_e + T K_t - p H_V + k v v^T
//
// K_e: plane-stress stiffness of linear triangles in space, which is stiff against normal loads
// where the skin is curved; K_t: int grad u : grad u, of the tension T, the same everywhere and in
// all directions; H_V: second derivative of the enclosed volume, because the pressure p stays
// normal to the rotating surface; v: its first derivative, along which the enclosed air resists
// compression. Source: total Lagrangian membrane (Bonet and Wood, Nonlinear Continuum Mechanics,
// 1997, ch. 8), linear about the rest shape. Without modulus, on a flat disc: Poisson's equation, T
// lap w = -q.
//
// Range: displacements that turn the surface by small angles and change T little. Frame O.
#pragma once

#include <array>
#include <memory>
#include <optional>
#include <span>
#include <vector>

#include <Eigen/Core>
#include <Eigen/Geometry>

#include "shared/mesh/solid_mesh.h"

namespace palpate {

using TriangleMatrix = Eigen::Matrix<double, 9, 9>;  // node by node, x y z

// One triangle of a membrane in space: its stiffnesses and the volume that it encloses.
class MembraneTriangle {
 public:
  explicit MembraneTriangle(const std::array<Eigen::Vector3d, 3>& p);

  [[nodiscard]] double area() const { return area_; }  // [m^2]
  [[nodiscard]] const Eigen::Vector3d& normal() const { return normal_; }

  // Plane stress at constant strain, per E h.
  [[nodiscard]] TriangleMatrix Elastic(double poisson_ratio) const;
  // int grad u : grad u.
  [[nodiscard]] TriangleMatrix Tension() const;
  // Second derivative of p0 . (p1 x p2) / 6, the volume of the cone from the origin.
  [[nodiscard]] TriangleMatrix Volume() const;

 private:
  std::array<Eigen::Vector3d, 3> p_;
  Eigen::Vector3d normal_;
  double area_ = 0;
  Eigen::Matrix3d gradients_;  // column k: of node k's shape function [1/m]
};

// The outer surface, and the nodes of its rim.
struct MembraneShape {
  SurfaceMesh surface;    // at rest, triangles counter-clockwise seen from outside
  std::vector<int> held;  // nodes that do not move
};

// Const members are thread-safe.
class InflatedMembrane {
 public:
  struct Params {
    double modulus = 0;          // E h: Young's modulus times thickness [N/m], >= 0
    double poisson_ratio = 0.5;  // -1 < nu <= 0.5
    double tension = 0;          // T [N/m], >= 0; it or the modulus > 0
    // P, inside minus outside [Pa]; absent: the pressure that balances T best.
    std::optional<double> pressure{};
    double air_stiffness = 0;  // k: pressure per displaced volume [Pa/m^3], >= 0
  };
  // Throws std::invalid_argument naming what is wrong: the parameter, a triangle, a node without
  // support; or that the rest shape is not stable at this pressure.
  InflatedMembrane(MembraneShape shape, const Params& params);
  ~InflatedMembrane();
  InflatedMembrane(InflatedMembrane&&) noexcept;
  InflatedMembrane& operator=(InflatedMembrane&&) noexcept;

  // Computes the displacements of the nodes [m] under `forces` on them [N]. Returns the rise of the
  // air's pressure [Pa]. Both have one entry per node; forces on fixed nodes are ignored.
  double Displace(std::span<const Eigen::Vector3d> forces,
                  std::vector<Eigen::Vector3d>* displacements) const;
  // nodes x nodes, symmetric [m/N]: displacement of node i along its normal under a unit force on
  // node j along its normal. O(nodes^2).
  [[nodiscard]] Eigen::MatrixXd NormalCompliance() const;

  [[nodiscard]] const SurfaceMesh& surface() const { return shape_.surface; }
  [[nodiscard]] const std::vector<int>& held() const { return shape_.held; }
  [[nodiscard]] bool IsHeld(int node) const { return held_[static_cast<std::size_t>(node)] != 0; }
  // Unit outward normals of the nodes, and the areas that a pressure acts on there [m^2]: together
  // the derivative v of the enclosed volume.
  [[nodiscard]] const std::vector<Eigen::Vector3d>& normals() const { return normals_; }
  [[nodiscard]] const std::vector<double>& areas() const { return areas_; }
  [[nodiscard]] double pressure() const { return pressure_; }  // p at rest [Pa]
  [[nodiscard]] const Params& params() const { return params_; }

 private:
  struct Factor;
  void FindNormals();
  void Assemble();

  MembraneShape shape_;
  Params params_;
  std::vector<char> held_;
  std::vector<int> unknown_;  // first component of a node; -1: fixed
  std::vector<Eigen::Vector3d> normals_;
  std::vector<double> areas_;
  double pressure_ = 0;
  std::unique_ptr<Factor> factor_;
};

// Shapes of membranes: a flat disc, and the part of an ellipsoid above the plane of its rim.
//
// p = centre + semi_axes times a point of the unit sphere.
struct Ellipsoid {
  Eigen::Vector3d centre{0, 0, 0};                          // [m]
  Eigen::Matrix3d semi_axes = Eigen::Matrix3d::Identity();  // symmetric, eigenvalues > 0 [m]
};

// Returns the distance of `p` from the ellipsoid, positive outside [m], to first order.
double DistanceOutside(const Ellipsoid& ellipsoid, const Eigen::Vector3d& p);

// Makes a flat disc in the plane z = 0 with its normal along z: `rings` rings of triangles around
// the centre, 6 rings^2 in total, with the outermost nodes fixed. Throws std::invalid_argument:
// radius not positive, rings not in 1 to 1000.
MembraneShape MeshFlatMembrane(double radius, int rings);
// Makes the part of the ellipsoid where p . axis > rim, relative to the centre; `axis` is a unit
// vector, the rim is fixed. Throws std::invalid_argument: as MeshFlatMembrane, or if the plane does
// not intersect the ellipsoid.
MembraneShape MeshDomedMembrane(const Ellipsoid& ellipsoid, const Eigen::Vector3d& axis, double rim,
                                int rings);

}  // namespace palpate
