// Finds an order of elimination of a graph's nodes that keeps factors sparse.
#pragma once

#include <vector>

namespace palpate {

// Neighbours of every node, itself included. Nodes, first to be eliminated first: METIS' nested
// dissection (Karypis and Kumar 1998), then so that each node comes soon after those it is
// eliminated after. The same for the same graph; one call runs at a time. Throws std::bad_alloc.
std::vector<int> EliminationOrder(const std::vector<std::vector<int>>& neighbours);

}  // namespace palpate
