// A deforming surface as it travels: what each node moved since the message before, in whole steps
// of a stated size, so that nothing adds up: a coordinate is off by at most a stated error, ever.
//
// Displacements are told in units of u = 2 e, e the error asked for. A message moves each node by
// r 2^k u, r whole; k = 0 wherever that fits into what a message may take, else the least that
// does, and what is missing follows with the next ones, a part of the nodes each. Nodes that moved
// by at most two steps along each axis take one symbol, the others three numbers more; both are
// compressed by zstd, which makes next to nothing of what stands still.
#pragma once

#include <cmath>
#include <cstddef>
#include <cstdint>
#include <optional>
#include <string>
#include <vector>

namespace palpate {

// Displacements x, y, z per node in units, as both ends know them.
using ShapeUnits = std::vector<std::int32_t>;

struct ShapeCode {
  int exponent = 0;   // k: the step is 2^k units
  std::string moves;  // compressed
};

class ShapeEncoder {
 public:
  // Nothing has moved yet. `unit` > 0 [m].
  void Restart(std::size_t nodes, double unit);
  // From `rest` to `positions` [m], x, y, z per node, in at most `budget` bytes where a step of
  // less than a million units will do. nullopt: sizes that do not fit, or a number that is none or
  // too large; nothing has changed then. O(nodes) for each step that is tried.
  std::optional<ShapeCode> Encode(const std::vector<float>& rest,
                                  const std::vector<float>& positions, std::size_t budget);
  [[nodiscard]] double unit() const { return unit_; }
  // By how much a coordinate is off at most, as told so far [m].
  [[nodiscard]] double error() const { return std::ldexp(unit_, exponent_ - 1); }

 private:
  // Moves in steps of 2^exponent. Nodes from `rough_from` on stay where they are off by less than
  // 2^tolerance / 2 units.
  struct Plan {
    int exponent = 0;
    std::size_t rough_from = 0;
    int tolerance = 0;
  };

  [[nodiscard]] std::int64_t Steps(double units, std::size_t i, const Plan& plan) const;
  [[nodiscard]] ShapeCode CodeOf(const std::vector<double>& units, const Plan& plan) const;
  [[nodiscard]] Plan FinerInPart() const;

  ShapeUnits told_;
  double unit_ = 1;
  int exponent_ = 0;      // all nodes are told in steps of 2^exponent_ or finer ones,
  std::size_t fine_ = 0;  // so many of the first of half of that
};

// Adds what a message tells to `told`. False: it is no such code; `told` is as it was.
[[nodiscard]] bool Decode(const ShapeCode& code, ShapeUnits* told);

}  // namespace palpate
