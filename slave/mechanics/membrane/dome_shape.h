// Shapes of membranes: a flat disc, and the part of an ellipsoid above the plane of its rim.
#pragma once

#include <Eigen/Core>

#include "slave/mechanics/membrane/inflated_membrane.h"

namespace palpate {

// p = centre + semi_axes times a point of the unit sphere.
struct Ellipsoid {
  Eigen::Vector3d centre{0, 0, 0};                          // [m]
  Eigen::Matrix3d semi_axes = Eigen::Matrix3d::Identity();  // symmetric, eigenvalues > 0 [m]
};

// How far `p` is outside [m], to first order in the distance.
double DistanceOutside(const Ellipsoid& ellipsoid, const Eigen::Vector3d& p);

// Flat, in the plane z = 0, normal along z; `rings` of triangles about the centre, 6 rings^2 in
// all, the outermost nodes fixed. Throws std::invalid_argument: radius not positive, rings not in 1
// to 1000.
MembraneShape MeshFlatMembrane(double radius, int rings);
// The part of the ellipsoid where p . axis > rim, relative to the centre; `axis` is a unit vector,
// the rim is fixed. Throws std::invalid_argument: as MeshFlatMembrane, or if the plane does not
// intersect the ellipsoid.
MembraneShape MeshDomedMembrane(const Ellipsoid& ellipsoid, const Eigen::Vector3d& axis, double rim,
                                int rings);

}  // namespace palpate
