// Counts that meshes of tetrahedra and of triangles have in common; CheckMesh puts them together.
#pragma once

#include <array>
#include <cstddef>
#include <string>
#include <vector>

#include <Eigen/Core>

#include "shared/mesh/mesh_check.h"

namespace palpate {

// "element 4, 7, 9 and 12 more".
std::string ListElements(const MeshNumbers& numbers, const std::vector<int>& elements);
std::string ListNodes(const MeshNumbers& numbers, const std::vector<int>& nodes);

// Bounding box of the used nodes, dangling and duplicate nodes, size: into the report, with
// warnings. `used`: per node.
void CountNodes(const std::vector<Eigen::Vector3d>& nodes, const std::vector<bool>& used,
                const MeshNumbers& numbers, bool unit_given, MeshReport* report);

// Qualities' minimum, median and slivers.
void CountQuality(std::vector<double> quality, const MeshNumbers& numbers, MeshReport* report);

// The part of each node, numbered from 0 in the order of the first element; -1: used by none.
template <std::size_t N>
std::vector<int> PartsOf(const std::vector<std::array<int, N>>& elements, std::size_t nodes,
                         int* parts);

// Finite nodes, node numbers in range, at least one element; otherwise refusals.
template <std::size_t N>
bool IsReadable(const std::vector<Eigen::Vector3d>& nodes,
                const std::vector<std::array<int, N>>& elements, const MeshNumbers& numbers,
                MeshReport* report);

// Elements that have the same nodes as an earlier one: refusals.
template <std::size_t N>
void RefuseDuplicates(const std::vector<std::array<int, N>>& elements, const MeshNumbers& numbers,
                      MeshReport* report);

// Per node: used by an element.
template <std::size_t N>
std::vector<bool> UsedNodes(const std::vector<std::array<int, N>>& elements, std::size_t nodes);

}  // namespace palpate
