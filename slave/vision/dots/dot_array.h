// Assigns the dots of an image to the dots of a known array: paper C, 3.2, which leaves this open.
#pragma once

#include <array>
#include <cstdint>
#include <span>
#include <utility>
#include <vector>

#include <Eigen/Core>

#include "slave/vision/dots/dot.h"
#include "slave/vision/dots/dot_growth.h"

namespace palpate {

// An array is any arrangement of three dots or more, regular or not, in its own plane (any unit).
// An image may show it rotated, shifted, tilted and bent, with missing and additional dots: only
// neighbours must keep their order.
class DotArray {
 public:
  // Orientation of x and y of the array's plane in the image: kAsDrawn as the image's x and y (y
  // down: the membrane from inside), kMirrored opposite.
  enum class Handedness : std::uint8_t { kAsDrawn, kMirrored, kEither };
  struct Params {
    Handedness handedness = Handedness::kAsDrawn;
    double gate = 0.35;       // a dot lies within so much of a spacing from where it is expected
    double area_ratio = 3;    // neighbours differ by no more; large: dots of different sizes
    double least_seen = 0.6;  // share of the array that must be there
  };
  static constexpr int kNobody = -1;  // [by definition]

  // `layout`: positions in the array's plane; the index is the dot's identity. Throws
  // std::invalid_argument: fewer than 3 or more than 400, two at the same position, all nearly
  // collinear, a parameter out of range.
  DotArray(std::vector<Eigen::Vector2d> layout, const Params& params);

  // Searches the array without earlier positions. `picks` gets for each dot of the array the index
  // in `dots`, or kNobody. A symmetric array fits in several ways: the one nearest to `hint` (a
  // position per dot of the array [px]) is selected; without one (empty) the one whose x points
  // most to the right. Returns the number of found dots; 0: not found. Bounded: at most 5 * 56
  // growths per candidate (5 * 132 among 13 or fewer), for 256 candidates: those nearest to the
  // hint, or first.
  int Match(std::span<const Dot> dots, std::span<const Eigen::Vector2d> hint,
            std::vector<int>* picks) noexcept;
  // Tracks the array: the dots nearest to `places`, one each, within the gate and with an area
  // within a factor of 2.5 of `areas` (0: any). Positions that are not finite get kNobody.
  int Follow(std::span<const Dot> dots, std::span<const Eigen::Vector2d> places,
             std::span<const double> areas, std::vector<int>* picks) noexcept;
  // Expected position of dot `k`, from the motion of its visible neighbours (an affine map of up to
  // six of them) since `before`. NaN without a visible neighbour.
  [[nodiscard]] Eigen::Vector2d Expect(std::size_t k, std::span<const Eigen::Vector2d> before,
                                       std::span<const Eigen::Vector2d> now,
                                       std::span<const char> seen) const noexcept;
  // Distance to the nearest neighbour of the array at `places` [px].
  [[nodiscard]] double Spacing(std::size_t k,
                               std::span<const Eigen::Vector2d> places) const noexcept;

  [[nodiscard]] std::size_t size() const { return layout_.size(); }
  [[nodiscard]] const std::vector<Eigen::Vector2d>& layout() const { return layout_; }
  // Its neighbours, nearest first, up to eight.
  [[nodiscard]] const std::vector<int>& neighbours(std::size_t k) const { return neighbours_[k]; }

 private:
  // A candidate's neighbours in the image.
  struct Around {
    static constexpr std::size_t kMost = 12;
    int count = 0;
    std::array<int, kMost> dots{};
  };

  void Choose(std::span<const Dot> dots, std::span<const Eigen::Vector2d> hint) noexcept;
  void FindNeighbours(std::span<const Dot> dots) noexcept;
  [[nodiscard]] bool SeedsFit(const Growth& growth, std::span<const Dot> dots,
                              const std::array<int, 3>& seeds) const noexcept;
  int Grow(const Growth& growth, std::span<const Dot> dots, const std::array<int, 3>& seeds,
           int to_beat) noexcept;
  [[nodiscard]] bool Better(int found, double cost, int best, double best_cost,
                            bool hinted) const noexcept;
  // [px^2]; infinite if the found dots do not fit the layout
  [[nodiscard]] double Cost(std::span<const Dot> dots,
                            std::span<const Eigen::Vector2d> hint) const noexcept;

  std::vector<Eigen::Vector2d> layout_;
  Params params_;
  int least_ = 0;
  std::vector<std::vector<int>> neighbours_;
  std::vector<Growth> growths_;
  // for the present image
  std::vector<int> candidates_;  // indices of `dots`
  std::vector<Around> around_;   // of each candidate
  DotIndex index_;
  std::vector<std::pair<double, int>> order_;  // distance, dot
  // Of one growth.
  std::vector<Eigen::Vector2d> places_;  // per dot of the array [px]
  std::vector<int> trial_;               // as `picks`
  std::vector<int> taken_;  // per dot of the image: the round and the dot that claimed it
  int round_ = 0;
};

}  // namespace palpate
