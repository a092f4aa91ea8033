// Doubles that begin at a multiple of 64 bytes, as wide registers like them.
#pragma once

#include <cstddef>
#include <vector>

namespace palpate {

class CacheLines {
 public:
  CacheLines() = default;
  // Zeros.
  explicit CacheLines(std::size_t count) : lines_((count + kPerLine - 1) / kPerLine) {}

  [[nodiscard]] double* data() noexcept { return lines_.empty() ? nullptr : lines_[0].numbers; }
  [[nodiscard]] const double* data() const noexcept {
    return lines_.empty() ? nullptr : lines_[0].numbers;
  }
  double& operator[](std::size_t i) noexcept { return data()[i]; }
  void Clear() noexcept { lines_.assign(lines_.size(), Line{}); }

 private:
  static constexpr std::size_t kPerLine = 8;
  struct alignas(64) Line {
    double numbers[kPerLine] = {};
  };
  std::vector<Line> lines_;
};

}  // namespace palpate
