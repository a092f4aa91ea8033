// Hexahedra for a round plate under a round tool: cubic along the plate and through it.
//
// One sector of the plate between mirror planes: half of it, or a quarter where the tool is at the
// centre. Elements lie between nested circles, closer to each other near the tool's edge and the
// rim, where a plate bends, and rays; the innermost ones have an edge without length.
#pragma once

#include <array>
#include <vector>

#include <Eigen/Core>

#include "slave/site/points/membrane/nested_circles.h"

namespace palpate::site {

class DiscMesh {
 public:
  static constexpr int kAcross = 3, kThrough = 3;  // degrees
  static constexpr int kElementColumns = (kAcross + 1) * (kAcross + 1);

  struct Size {
    int inner_rings = 0, outer_rings = 0;  // of elements, below the tool and beside it
    int rays = 0;                          // elements in the sector's angle
    int layers = 0;
  };
  // All in the unit of `circles`; the plate reaches from -thickness / 2 to thickness / 2.
  DiscMesh(const NestedCircles& circles, double thickness, const Size& size);

  [[nodiscard]] const NestedCircles& circles() const { return circles_; }
  [[nodiscard]] double thickness() const { return thickness_; }
  [[nodiscard]] bool is_quarter() const { return circles_.eccentricity == 0; }
  [[nodiscard]] int rings() const { return size_.inner_rings + size_.outer_rings; }
  [[nodiscard]] int inner_rings() const { return size_.inner_rings; }
  [[nodiscard]] int rays() const { return size_.rays; }
  [[nodiscard]] int layers() const { return size_.layers; }

  // Lines of nodes: circles from 0, the tool's centre, to the rim; rays; levels upward.
  [[nodiscard]] int circle_lines() const { return kAcross * rings() + 1; }
  [[nodiscard]] int ray_lines() const { return kAcross * size_.rays + 1; }
  [[nodiscard]] int levels() const { return kThrough * size_.layers + 1; }
  [[nodiscard]] const std::vector<double>& circle_places() const { return s_; }  // s, per line
  // Columns of nodes through the plate, in the order of their elimination; those that are clamped
  // come last.
  [[nodiscard]] int columns() const { return static_cast<int>(places_.size()); }
  [[nodiscard]] int free_columns() const { return free_columns_; }
  [[nodiscard]] int column(int circle, int ray) const {
    const int i = circle == 0 ? 0 : 1 + (circle - 1) * ray_lines() + ray;
    return column_[static_cast<std::size_t>(i)];
  }
  [[nodiscard]] const Eigen::Vector2d& place(int column) const {
    return places_[static_cast<std::size_t>(column)];
  }
  // Of the elements at (ring, ray): circle by circle outward, on each along the angle.
  [[nodiscard]] std::array<int, kElementColumns> element(int ring, int ray) const;
  // Components of a column's displacement that the mirror planes hold.
  [[nodiscard]] std::array<bool, 3> Held(int circle, int ray) const;

 private:
  void PlaceCircles();
  void OrderColumns();

  NestedCircles circles_;
  double thickness_;
  Size size_;
  int free_columns_ = 0;
  std::vector<double> s_;
  std::vector<int> column_;  // per crossing of lines
  std::vector<Eigen::Vector2d> places_;
};

}  // namespace palpate::site
