// Traversal of the search trees of this folder: binary trees of boxes, root first. Leaves own a
// range of elements [begin, end), inner boxes two boxes, `left` and `right`.
#pragma once

#include <array>
#include <vector>

#include "slave/mesh/index.h"

namespace palpate {

// Boxes still to be visited: never more than one per level and one wait. Allocation-free.
class BoxStack {
 public:
  void Push(int box) { boxes_[Index(size_++)] = box; }
  int Pop() { return boxes_[Index(--size_)]; }
  [[nodiscard]] bool empty() const { return size_ == 0; }

 private:
  static constexpr int kDeepest = 64;  // [levels] [derived: halving 2^32 elements takes 32]
  std::array<int, kDeepest + 1> boxes_{};
  int size_ = 0;
};

// Calls `visit` with the number of every element in a box whose `distance` is at most `limit`,
// which `visit` may lower. Nearer boxes come first.
template <class Box, class Distance, class Visit>
void VisitNearest(const std::vector<Box>& boxes, const double& limit, const Distance& distance,
                  const Visit& visit) {
  BoxStack stack;
  for (stack.Push(0); !stack.empty();) {
    const Box& box = boxes[Index(stack.Pop())];
    if (distance(box) > limit) continue;
    if (box.left >= 0) {
      const bool is_left_nearer =
          distance(boxes[Index(box.left)]) < distance(boxes[Index(box.right)]);
      stack.Push(is_left_nearer ? box.right : box.left);
      stack.Push(is_left_nearer ? box.left : box.right);
      continue;
    }
    for (int k = box.begin; k < box.end; ++k) visit(k);
  }
}

}  // namespace palpate
