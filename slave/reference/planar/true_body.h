// The true geometry of the simulated body: its outline, fixed parts, and pose in S. Plane
// coordinates of frame O [m] unless a name says otherwise.
#pragma once

#include <optional>
#include <utility>
#include <vector>

#include <Eigen/Core>
#include <Eigen/Geometry>

#include "slave/scene/scene.h"

namespace palpate::simulation {

// A point on the boundary: loop 0 is the outer one, then the holes; `s` is the arc length from the
// first corner of the loop [m], the body on the left.
struct BoundaryPlace {
  int loop = 0;
  double s = 0;
  Eigen::Vector2d p_O{0, 0};
  Eigen::Vector2d normal_O{0, 0};  // outward, unit length
};

class TrueBody {
 public:
  // Edge is a straight piece of a loop, fixed or free over its whole length.
  struct Edge {
    int loop = 0;
    double s = 0;  // arc length at its start
    Eigen::Vector2d a{0, 0}, b{0, 0};
    bool is_held = false;
    [[nodiscard]] double length() const { return (b - a).norm(); }
    [[nodiscard]] Eigen::Vector2d normal() const {
      const Eigen::Vector2d t = (b - a) / length();
      return {t.y(), -t.x()};
    }
  };

  // Throws std::invalid_argument naming the key: an outline that needs an image, a pose that leaves
  // the plane, no part of the boundary fixed, nodes fixed by number (they belong to a model's mesh,
  // which the simulator does not share).
  explicit TrueBody(const Scene& scene);

  [[nodiscard]] const std::vector<Edge>& edges() const { return edges_; }  // loop after loop
  [[nodiscard]] double loop_length(int loop) const;
  [[nodiscard]] double larger_side() const { return larger_side_; }  // of the bounding box [m]
  [[nodiscard]] Eigen::Vector2d lower_corner() const { return lower_; }
  [[nodiscard]] Eigen::Vector2d upper_corner() const { return upper_; }
  [[nodiscard]] const Eigen::Isometry2d& X_SO() const { return X_SO_; }  // misplacement included

  [[nodiscard]] bool Contains(const Eigen::Vector2d& p) const noexcept;
  // Returns where the line from `from` to `to` first enters the body.
  [[nodiscard]] std::optional<BoundaryPlace> Entry(const Eigen::Vector2d& from,
                                                   const Eigen::Vector2d& to) const noexcept;
  [[nodiscard]] BoundaryPlace Nearest(const Eigen::Vector2d& p) const noexcept;
  // The point at `s` along `loop`; s is taken modulo the loop's length.
  [[nodiscard]] BoundaryPlace PlaceAt(int loop, double s) const noexcept;
  // Returns the contact of a rigid tool of `width` [m] centred at `place`, from and to along the
  // loop. It follows gentle bends and ends at corners sharper than 30 degrees, where a real tool
  // overhangs.
  [[nodiscard]] std::pair<double, double> Patch(const BoundaryPlace& place, double width) const;

 private:
  void AddLoop(std::vector<Eigen::Vector2d> loop, bool counter_clockwise);
  void SplitAtArcs(const std::vector<Fixed>& fixed);
  void Hold(const Fixed& fixed);
  [[nodiscard]] std::size_t EdgeAt(int loop, double s) const noexcept;

  std::vector<Edge> edges_;
  std::vector<std::size_t> loop_begin_;  // loops + 1 entries
  Eigen::Vector2d lower_{0, 0}, upper_{0, 0};
  double larger_side_ = 0;
  Eigen::Isometry2d X_SO_ = Eigen::Isometry2d::Identity();
};

}  // namespace palpate::simulation
