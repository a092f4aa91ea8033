// Error of the rendered force over the ticks of contact, when what counts as contact (1 % of the
// peak) is known only at the end. Fixed memory for runs of any length: sums per magnitude, in bins
// 1 % wide, so the border of "contact" is sharp to 1 % of itself.
#pragma once

#include <array>
#include <cstdint>

#include <Eigen/Core>

namespace palpate {

class ForceError {
 public:
  struct Summary {
    double rms = 0, peak = 0;  // of |local - truth| [N]
    std::uint64_t ticks = 0;
  };
  // One tick: forces in S [N], finite.
  void Add(const Eigen::Vector3d& local, const Eigen::Vector3d& truth) noexcept;
  // Over the ticks in which either force exceeds `threshold` [N].
  [[nodiscard]] Summary Above(double threshold) const noexcept;
  [[nodiscard]] bool empty() const noexcept { return count_ == 0; }

 private:
  struct Bin {
    double sum_of_squares = 0, peak = 0;
    std::uint64_t ticks = 0;
  };
  static constexpr int kBins = 4000;  // 1 pN to 190 kN
  std::array<Bin, kBins> bins_{};
  std::uint64_t count_ = 0;
};

}  // namespace palpate
