// Precomputed table of one tool's force anywhere on a clamped plate: a lookup within a microsecond,
// where the plate's model needs up to a millisecond.
#pragma once

#include <vector>

#include "slave/mechanics/plate/plate_surface.h"

namespace palpate {

// The secant stiffness S = F / d over radius and depth, which by symmetry depends on the radius
// only. It is interpolated between depths by cubics with the model's tangents, and between radii by
// cubics through four neighbours of S (1 - r^2 / a^2)^2, which varies little; r: radius of the
// tool's centre, for a rigid tool of its outermost point. Within 0.5 % of the model up to three
// quarters of the radius. Const members are thread-safe.
class PressTable {
 public:
  // Solves `plate` a few hundred times and leaves it at rest.
  // Throws std::runtime_error: the model finds no solution even for small depths.
  PressTable(PlateSurface& plate, const PlateSurface::Tool& tool);

  struct Press {
    double force = 0, stiffness = 0;  // size of the force [N], d force / d depth [N/m]
    bool valid = false;               // inside the model's range
  };
  // Returns the press at `radius` [m] from the centre, `depth` [m] below the plane at rest. At
  // depth <= 0 it has no force and the stiffness of the first contact. Beyond largest_radius() it
  // is the value there. Beyond the model's range it is extrapolated along the last tangent. If an
  // argument is not finite, it has no force and is not valid. No allocation.
  [[nodiscard]] Press At(double radius, double depth) const noexcept;
  [[nodiscard]] double largest_radius() const noexcept { return largest_radius_; }  // [m]

 private:
  struct Entry {
    double secant = 0, slope = 0;  // S RimShare [N/m], its change from row to row
  };
  [[nodiscard]] double Deepest(double r) const noexcept;
  void FillColumn(PlateSurface& plate, int column);
  [[nodiscard]] double ValidDepth(PlateSurface& plate, double r) const;
  [[nodiscard]] const Entry& EntryAt(int column, int row) const;

  [[nodiscard]] double RimShare(double r) const noexcept;

  PlateSurface::Tool tool_;
  double radius_ = 0, largest_radius_ = 0;  // [m]
  // Row k at the depth (k / (rows - 1))^2 of the deepest: a thin plate stiffens early.
  std::vector<Entry> entries_;        // rows fastest
  std::vector<double> valid_depths_;  // per column [m]
};

}  // namespace palpate
