// How a rigid flat face holds the nodes at its rim.
//
// A mesh has no nodes on the rim, so a face that holds whole nodes is wider or narrower than the
// true one by up to half an element: 5 to 15 % of the force with four elements across. Each node
// stands for a part of the surface. A face holds a node rigidly if that part lies under it, and
// through a spring if only the share s of it does:
//
//   c = (1 / s - 1) c_even
//
// c_even: compliance of a half-space under an even load over the node's part, taken as a disc.
// Nodes of four-node tetrahedra have that compliance within a tenth on lattices and on unstructured
// meshes. The force then changes steadily as the face moves over the mesh. Against truths on boxes
// (nu 0.2 to 0.4, without locking) it is off by -8 to +1 % with two elements across, by -4 to +1 %
// with four and by -1.5 to +1 % from eight on (whole nodes: up to 15 % and 7 %).
#pragma once

#include "slave/mechanics/footprint/disc_compliance.h"

namespace palpate {

// A node with a smaller share is free: its spring would carry less than a hundredth of its force.
inline constexpr double kLeastShare = 0.01;
// A node with a larger share is held rigidly.
inline constexpr double kWholeShare = 0.99;
// Factor on the springs of four-node elements with a stabilised pressure [-]. [measured: 56 discs
// on boxes, nu 0.4 to 0.495, lattices and unstructured meshes of 2 to 11 elements across: 0.3 % too
// soft in the mean at every ratio]
inline constexpr double kSpringOfMixed = 0.7;

// Radius of the disc that has the area of a node's part of the surface: a third of each triangle
// around it.
double PartRadius(double area) noexcept;

// Share of a node's part that lies under a disc of `radius`, whose centre is `distance` away along
// the surface [0 to 1]. All lengths in one unit.
double ShareUnderDisc(double radius, double part_radius, double distance) noexcept;
// The same under a rectangle of half sides `along`, `across`, with the node at (x, y) from its
// centre.
double ShareUnderRectangle(double along, double across, double part_radius, double x,
                           double y) noexcept;

// Compliance of a node's spring, times Young's modulus [1 / length]. 0 < share <= 1.
DiscCompliance SpringAtRim(double poisson_ratio, double part_radius, double share) noexcept;

}  // namespace palpate
