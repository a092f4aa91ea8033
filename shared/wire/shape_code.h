// Code of a deforming surface: the displacement of each node since the previous message, in whole
// steps. Errors do not accumulate: each coordinate stays within a stated error.
//
// Displacements have units of u = 2 e, where e is the requested error. A message moves each node by
// r 2^k u with integer r. k is 0 if that fits into the size of a message, otherwise the least that
// fits. The rest follows with the next messages for a part of the nodes each. Nodes that move at
// most two steps along each axis take one symbol, others three more numbers. zstd compresses both,
// so that stationary nodes cost almost nothing.
#pragma once

#include <cmath>
#include <cstddef>
#include <cstdint>
#include <optional>
#include <string>
#include <vector>

namespace palpate {

// Displacements x, y, z per node in units, known to both ends.
using ShapeUnits = std::vector<std::int32_t>;

struct ShapeCode {
  int exponent = 0;   // k: the step is 2^k units
  std::string moves;  // compressed
};

class ShapeEncoder {
 public:
  // Starts with zero displacements. `unit` > 0 [m].
  void Restart(std::size_t nodes, double unit);
  // Encodes `positions` relative to `rest` [m], x, y, z per node, in at most `budget` bytes if a
  // step below a million units suffices. nullopt: sizes differ, or a number is not finite or too
  // large; the state is then unchanged. O(nodes) per tried step.
  std::optional<ShapeCode> Encode(const std::vector<float>& rest,
                                  const std::vector<float>& positions, std::size_t budget);
  [[nodiscard]] double unit() const { return unit_; }
  // Largest present error of a coordinate [m].
  [[nodiscard]] double error() const { return std::ldexp(unit_, exponent_ - 1); }

 private:
  // Steps of 2^exponent. Nodes from `rough_from` on keep an error below 2^tolerance / 2 units.
  struct Plan {
    int exponent = 0;
    std::size_t rough_from = 0;
    int tolerance = 0;
  };

  [[nodiscard]] std::int64_t Steps(double units, std::size_t i, const Plan& plan) const;
  [[nodiscard]] ShapeCode CodeOf(const std::vector<double>& units, const Plan& plan) const;
  [[nodiscard]] Plan FinerInPart() const;

  ShapeUnits sent_;
  double unit_ = 1;
  int exponent_ = 0;      // all nodes are sent in steps of 2^exponent_ or finer,
  std::size_t fine_ = 0;  // the first fine_ nodes in half of that
};

// Adds the displacements of a message to `units`. False: invalid code; `units` is unchanged.
[[nodiscard]] bool Decode(const ShapeCode& code, ShapeUnits* units);

// Code of the traction at each node: one byte per node, compressed by zstd.
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
