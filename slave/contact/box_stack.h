// What the search trees of this folder still have to visit.
#pragma once

#include <array>
#include <cstddef>

namespace palpate {

// Boxes of a binary tree of at most `kDeepest` levels: never more than one per level and one wait.
// Allocation-free.
template <int kDeepest>
class BoxStack {
 public:
  void Push(int box) { boxes_[static_cast<std::size_t>(size_++)] = box; }
  int Pop() { return boxes_[static_cast<std::size_t>(--size_)]; }
  [[nodiscard]] bool empty() const { return size_ == 0; }

 private:
  std::array<int, kDeepest + 1> boxes_{};
  int size_ = 0;
};

}  // namespace palpate
