// Draws for scenes and presses: the same from the same seed with every standard library.
#pragma once

#include <algorithm>
#include <cmath>
#include <cstdint>
#include <numbers>
#include <random>

namespace palpate {

class Dice {
 public:
  explicit Dice(std::uint32_t seed) : engine_(seed) { engine_.discard(16); }
  double Share() { return static_cast<double>(engine_()) / 4294967296.0; }  // [0, 1)
  double Between(double low, double high) { return low + (high - low) * Share(); }
  double Decades(double low, double high) { return low * std::pow(high / low, Share()); }
  bool Chance(double p) { return Share() < p; }
  int Whole(int low, int high) { return low + static_cast<int>(Share() * (high - low + 1)); }
  // A normal number of mean 0 and variance 1 (Box and Muller 1958).
  double Normal() {
    const double radius = std::sqrt(-2 * std::log(std::max(1 - Share(), 1e-12)));
    return radius * std::cos(2 * std::numbers::pi * Share());
  }

 private:
  std::mt19937 engine_;
};

}  // namespace palpate
