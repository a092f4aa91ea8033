// Checks common to meshes of tetrahedra and of triangles, used by CheckMesh.
#pragma once

#include <array>
#include <cstddef>
#include <limits>
#include <string>
#include <vector>

#include <Eigen/Core>

#include "slave/mesh/mesh_check.h"

namespace palpate {

// Height of a degenerate element, relative to the longest edge ...
inline constexpr double kFlatElement = 1e-12;
// ... and relative to the largest coordinate: the rounding of three differences.
inline constexpr double kCoordinateRounding = 8 * std::numeric_limits<double>::epsilon();

// "element 4, 7, 9 and 12 more".
std::string ListElements(const MeshNumbers& numbers, const std::vector<int>& elements);
std::string ListNodes(const MeshNumbers& numbers, const std::vector<int>& nodes);

// Adds bounding box of used nodes, dangling and duplicate nodes and size to the report, with
// warnings. `used`: per node.
void CountNodes(const std::vector<Eigen::Vector3d>& nodes, const std::vector<bool>& used,
                const MeshNumbers& numbers, bool unit_given, MeshReport* report);

// Adds minimum and median quality and slivers.
void CountQuality(std::vector<double> quality, const MeshNumbers& numbers, MeshReport* report);

// The part of each node, numbered from 0 in the order of the first element; -1: used by none.
template <std::size_t N>
std::vector<int> PartsOf(const std::vector<std::array<int, N>>& elements, std::size_t nodes,
                         int* parts);

// Returns whether nodes are finite, node numbers in range, and there is an element; otherwise adds
// refusals.
template <std::size_t N>
bool IsReadable(const std::vector<Eigen::Vector3d>& nodes,
                const std::vector<std::array<int, N>>& elements, const MeshNumbers& numbers,
                MeshReport* report);

// Adds refusals for elements with the same nodes as an earlier one.
template <std::size_t N>
void RefuseDuplicates(const std::vector<std::array<int, N>>& elements, const MeshNumbers& numbers,
                      MeshReport* report);

// Returns whether each node is used by an element.
template <std::size_t N>
std::vector<bool> UsedNodes(const std::vector<std::array<int, N>>& elements, std::size_t nodes);

}  // namespace palpate
