// Bytes as choices: a sequence of calls that a fuzzer, or a generator of random numbers, decides.
#pragma once

#include <array>
#include <cstddef>
#include <cstdint>
#include <limits>
#include <random>
#include <span>
#include <stdexcept>
#include <string>
#include <vector>

#include <Eigen/Core>

namespace palpate {

class Choices {
 public:
  explicit Choices(std::span<const std::uint8_t> bytes) : bytes_(bytes) {}

  [[nodiscard]] bool over() const { return at_ >= bytes_.size(); }
  // Returns the next byte; 0 after the end.
  std::uint8_t Byte() { return over() ? 0 : bytes_[at_++]; }
  // Below `count`.
  std::size_t Below(std::size_t count) { return Byte() % count; }
  bool Coin() { return (Byte() & 1U) != 0; }
  template <class T, std::size_t kCount>
  T Among(const std::array<T, kCount>& offered) {
    return offered[Below(kCount)];
  }
  // From `low` to `high`.
  double Within(double low, double high) { return low + (high - low) * Byte() / 255; }
  Eigen::Vector3d Within(double size) {
    return {Within(-size, size), Within(-size, size), Within(-size, size)};
  }
  // Returns a value that no correct peer sends.
  double Wild() {
    using Limits = std::numeric_limits<double>;
    constexpr std::array<double, 13> kWild{0,
                                           -1,
                                           1e-300,
                                           -1e-9,
                                           1e-6,
                                           3,
                                           1e3,
                                           -1e6,
                                           1e12,
                                           1e300,
                                           Limits::quiet_NaN(),
                                           Limits::infinity(),
                                           Limits::denorm_min()};
    return Among(kWild);
  }

 private:
  std::span<const std::uint8_t> bytes_;
  std::size_t at_ = 0;
};

// Checks a condition that must hold for any choices. Throws std::logic_error.
inline void Demand(bool holds, const std::string& what) {
  if (!holds) throw std::logic_error(what);
}

inline std::vector<std::uint8_t> RandomBytes(unsigned seed, std::size_t size) {
  std::mt19937 random(seed);
  std::vector<std::uint8_t> bytes(size);
  for (std::uint8_t& byte : bytes) byte = static_cast<std::uint8_t>(random() & 0xffU);
  return bytes;
}

}  // namespace palpate
