// Finds an order of elimination of a graph's nodes that keeps factors sparse.
#pragma once

#include <vector>

namespace palpate {

// Returns the nodes in their order of elimination. `neighbours` of a node contain the node itself.
// The order is METIS' nested dissection (Karypis and Kumar 1998), rearranged so that each node
// follows soon after those on which it depends. The same graph gives the same order. One call runs
// at a time. Throws std::bad_alloc.
std::vector<int> EliminationOrder(const std::vector<std::vector<int>>& neighbours);

}  // namespace palpate
