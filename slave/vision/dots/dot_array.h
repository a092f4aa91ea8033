// Assigns the dots of an image to the dots of a known array; paper C, 3.2, does not describe this
// step.
#pragma once

#include <span>
#include <vector>

#include <Eigen/Core>

#include "slave/vision/dots/dot.h"

namespace palpate {

// An array is any arrangement of three dots or more, regular or not, in its own plane (any unit).
class DotArray {
 public:
  static constexpr int kNoDot = -1;  // [by definition]

  // `layout`: positions in the array's plane; the index is the dot's identity. Throws
  // std::invalid_argument: fewer than 3 or more than 400, two at the same position, all nearly
  // collinear, not finite.
  explicit DotArray(std::vector<Eigen::Vector2d> layout);

  // Finds the dots of the array near their expected positions `places` [px], with an area within a
  // factor of 2.5 of `areas` (0: any). The whole array may be shifted by two spacings, rotated and
  // stretched so that neighbours keep their order. `picks` gets for each dot of the array the index
  // in `dots`, or kNoDot. Returns the number of assigned dots.
  int Identify(std::span<const Dot> dots, std::span<const Eigen::Vector2d> places,
               std::span<const double> areas, std::vector<int>* picks) const;
  // Returns the expected position of dot `k`, from the motion of its visible neighbours (an affine
  // map of up to eight of them) since `before`. NaN without a visible neighbour.
  [[nodiscard]] Eigen::Vector2d Expect(std::size_t k, std::span<const Eigen::Vector2d> before,
                                       std::span<const Eigen::Vector2d> now,
                                       std::span<const char> seen) const;
  // Returns the distance to the nearest neighbour of the array at `places` [px].
  [[nodiscard]] double Spacing(std::size_t k, std::span<const Eigen::Vector2d> places) const;

  [[nodiscard]] std::size_t size() const { return layout_.size(); }
  // Returns the neighbours of dot `k`, nearest first, up to eight.
  [[nodiscard]] const std::vector<int>& neighbours(std::size_t k) const { return neighbours_[k]; }

 private:
  using Places = std::vector<Eigen::Vector2d>;

  struct Image;  // data of one image
  int Grow(const Image& image, std::size_t anchor, const Eigen::Vector2d& shift,
           std::vector<int>* picks) const;
  int Assign(const Image& image, const Places& expected, std::vector<int>* picks) const;
  [[nodiscard]] Places Adapted(const Image& image, const std::vector<int>& picks) const;

  Places layout_;
  std::vector<std::vector<int>> neighbours_;
  std::vector<std::size_t> anchors_;  // from the centre outwards
};

}  // namespace palpate
