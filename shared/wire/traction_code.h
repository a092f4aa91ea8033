// Code of the traction at each node: one byte per node, compressed by zstd.
#pragma once

#include <cstddef>
#include <cstdint>
#include <optional>
#include <string>
#include <vector>

namespace palpate {

struct NodeTraction {
  double unit = 0;                  // size of a step [Pa], > 0; the error is at most half of it
  std::vector<std::uint8_t> steps;  // one per node; empty: unknown
};

// Quantises with the smallest step for which Packed needs at most `budget` bytes. The result has no
// steps if a value is negative or not finite, or no step fits.
NodeTraction Quantised(const std::vector<double>& pascals, std::size_t budget);

std::string Packed(const NodeTraction& traction);
// nullopt: invalid code for `nodes` nodes, or invalid `unit`.
std::optional<NodeTraction> Unpacked(double unit, const std::string& packed, std::size_t nodes);

}  // namespace palpate
