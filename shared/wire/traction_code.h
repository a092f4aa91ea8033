// How hard a surface is pushed, node by node, as it travels: a byte each, which zstd makes next to
// nothing of where nothing touches.
#pragma once

#include <cstddef>
#include <cstdint>
#include <optional>
#include <string>
#include <vector>

namespace palpate {

struct NodeTraction {
  double unit = 0;                  // of a step [Pa], > 0; each node is off by at most half of it
  std::vector<std::uint8_t> steps;  // one per node; empty: not known
};

// In steps as small as `budget` bytes of Packed allow. Without steps: a number that is negative or
// none, or no steps that small.
NodeTraction Quantised(const std::vector<double>& pascals, std::size_t budget);

std::string Packed(const NodeTraction& traction);
// nullopt: it is no such code of `nodes` nodes, or `unit` is no traction.
std::optional<NodeTraction> Unpacked(double unit, const std::string& packed, std::size_t nodes);

}  // namespace palpate
