// Integrals of Kelvin's solution over a flat triangle on which the traction is constant and the
// displacement linear, in closed form wherever the point lies.
//
// A unit force at x in direction i causes at y, r = y - x, the displacement U_ij and, on a cut with
// normal n, the traction T_ij in direction j (shear modulus G):
//
//   U_ij = [ (3 - 4 nu) d_ij + r,i r,j ] / (16 pi G (1 - nu) r)
//   T_ij = -[ ((1 - 2 nu) d_ij + 3 r,i r,j) dr/dn - (1 - 2 nu) (r,i n_j - r,j n_i) ]
//          / (8 pi (1 - nu) r^2)
//
// Source: Brebbia, Telles and Wrobel, Boundary Element Techniques (1984), eqs. (5.1.7)-(5.1.9).
// In the triangle's plane r is constant along n, every kernel is a derivative of 1 / r or r, and
// the divergence theorem leaves the solid angle and integrals of 1 / r and 1 / r^3 along the edges.
// All differences in those are taken analytically, so that nothing cancels on an edge's line or far
// away. What is left of rounding is about 1e-16 times distance / size, for what grows linearly
// times the square of length / width.
#pragma once

#include <array>

#include <Eigen/Core>

namespace palpate {

// Nondimensional. Corners are counter-clockwise seen from where the normal points.
struct FlatTriangle {
  std::array<Eigen::Vector3d, 3> corners;
  std::array<Eigen::Vector3d, 3> along;    // unit vectors of the edges from corner e to e + 1
  std::array<Eigen::Vector3d, 3> outward;  // unit vectors in the plane, across the edges
  std::array<double, 3> lengths{};         // of the edges
  Eigen::Vector3d normal{0, 0, 0};
  Eigen::Vector3d centroid{0, 0, 0};
  double area = 0;

  FlatTriangle(const Eigen::Vector3d& a, const Eigen::Vector3d& b, const Eigen::Vector3d& c);
};

// Under which the triangle is seen from `x`, positive from behind; 2 pi in size at the most.
double SolidAngle(const FlatTriangle& triangle, const Eigen::Vector3d& x);

// The constants of the two kernels; moduli over Young's modulus.
struct KelvinSolidConstants {
  double u, t;    // 1 / (16 pi G (1 - nu)), 1 / (8 pi (1 - nu))
  double u_mean;  // 3 - 4 nu
  double t_skew;  // 1 - 2 nu

  explicit KelvinSolidConstants(double nu);
};

// What values on a triangle contribute at a point: row i for the unit force's direction, column j
// for the component of the traction or displacement. Principal values on the triangle itself.
struct KelvinSolidBlocks {
  Eigen::Matrix3d of_traction;      // integral of U_ij
  Eigen::Matrix3d of_displacement;  // integral of T_ij
  // Integrals of T_ij (b_k - 1 / 3) with the barycentric coordinate b_k of corner k: what a
  // displacement adds that grows linearly from the centroid.
  std::array<Eigen::Matrix3d, 3> of_corner;
};

// At the point `x` off the triangle. On one of its edges: not finite.
KelvinSolidBlocks IntegrateKelvin(const KelvinSolidConstants& constants,
                                  const FlatTriangle& triangle, const Eigen::Vector3d& x);
// At the triangle's own centroid.
KelvinSolidBlocks IntegrateKelvinOnItself(const KelvinSolidConstants& constants,
                                          const FlatTriangle& triangle);

}  // namespace palpate
