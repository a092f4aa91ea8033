// A list of numbers of bounded length, without allocation.
#pragma once

#include <algorithm>
#include <array>
#include <cassert>
#include <cstddef>

namespace palpate {

// At most `kMaxSize` values; `kUsual` zeros at first.
template <typename T, std::size_t kMaxSize, std::size_t kUsual>
class ShortList {
 public:
  using value_type = T;

  [[nodiscard]] std::size_t size() const noexcept { return size_; }
  // New values are zero.
  void resize(std::size_t size) noexcept {
    assert(size <= kMaxSize);
    if (size > size_) std::fill(values_.begin() + size_, values_.begin() + size, T{});
    size_ = size;
  }
  [[nodiscard]] T* data() noexcept { return values_.data(); }
  [[nodiscard]] const T* data() const noexcept { return values_.data(); }
  [[nodiscard]] T* begin() noexcept { return data(); }
  [[nodiscard]] T* end() noexcept { return data() + size_; }
  [[nodiscard]] const T* begin() const noexcept { return data(); }
  [[nodiscard]] const T* end() const noexcept { return data() + size_; }
  [[nodiscard]] T& operator[](std::size_t i) noexcept { return values_[i]; }
  [[nodiscard]] const T& operator[](std::size_t i) const noexcept { return values_[i]; }
  [[nodiscard]] T& back() noexcept { return values_[size_ - 1]; }
  [[nodiscard]] const T& back() const noexcept { return values_[size_ - 1]; }
  void fill(const T& value) noexcept { std::fill(begin(), end(), value); }
  bool operator==(const ShortList& other) const noexcept {
    return std::equal(begin(), end(), other.begin(), other.end());
  }

 private:
  std::array<T, kMaxSize> values_{};
  std::size_t size_ = kUsual;
};

}  // namespace palpate
