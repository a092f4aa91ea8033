// In which order to eliminate the nodes of a mesh, so that factors stay sparse.
#pragma once

#include <vector>

#include "slave/mechanics/fem/solid/element_mesh.h"

namespace palpate {

// Neighbours of every node, itself included, rising.
std::vector<std::vector<int>> NeighboursOf(const ElementMesh& mesh);

// The better of approximate minimum degree and nested dissection (halves of the elements by place,
// the nodes between them last), by the work of a factorisation.
std::vector<int> EliminationOrder(const ElementMesh& mesh,
                                  const std::vector<std::vector<int>>& neighbours);

}  // namespace palpate
