// Histogram of times in logarithmic bins: fixed memory, real-time safe, quantiles within 2 %.
#pragma once

#include <array>
#include <cstdint>

namespace palpate {

// LatencyHistogram is not thread-safe.
class LatencyHistogram {
 public:
  // `us` [us]; negative and not finite count as 0. Real-time safe.
  void Add(double us) noexcept;
  // The smallest bin edge above at least the fraction `q` in [0, 1] of all times [us]; 0 if empty.
  [[nodiscard]] double Quantile(double q) const noexcept;
  [[nodiscard]] double max() const noexcept { return max_; }  // exact [us]
  [[nodiscard]] std::uint64_t count() const noexcept { return count_; }

 private:
  // 10 ns to 1000 s in steps of 2 %.
  static constexpr int kBins = 1280;
  std::array<std::uint32_t, kBins> bins_{};
  std::uint64_t count_ = 0;
  double max_ = 0;
};

}  // namespace palpate
