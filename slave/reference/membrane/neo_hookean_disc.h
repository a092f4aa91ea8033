// Coordinates, mesh and forces of a round rubber plate under a round tool.
#pragma once

#include <array>
#include <vector>

#include <Eigen/Core>

#include "slave/reference/solid/neo_hookean_body.h"

namespace palpate::simulation {

// Hexahedral mesh for a round plate under a round tool, cubic along the plate and through it.
//
// It covers one sector of the plate between mirror planes: half of it, or a quarter if the tool is
// at the centre. Elements lie between nested circles, closer to each other near the tool's edge and
// the rim, where a plate bends, and rays; the innermost ones have an edge without length.
// Coordinates of a round plate that suit a round tool anywhere on it: circles about the tool's
// centre below it and, between its edge and the rim, circles whose centres and radii change evenly.
// Frame: origin at the plate's centre, the tool's centre on the x axis at `eccentricity` >= 0, with
// eccentricity + tool < radius. Any unit.
struct NestedCircles {
  double radius = 0;        // of the plate
  double tool = 0;          // radius of the tool
  double eccentricity = 0;  // of the tool's centre

  struct Place {
    double s = 0;      // 0 at the tool's centre, 1 at its edge, 2 at the rim
    double angle = 0;  // about the centre of the circle `s`, from the x axis [rad], -pi to pi
  };
  [[nodiscard]] Eigen::Vector2d At(const Place& place) const noexcept;
  // s exceeds 2 beyond the rim and grows with the distance, up to twice the radius.
  [[nodiscard]] Place Of(const Eigen::Vector2d& p) const noexcept;
};

class DiscMesh {
 public:
  static constexpr int kAcross = 3, kThrough = 3;  // degrees
  static constexpr int kElementColumns = (kAcross + 1) * (kAcross + 1);

  struct Size {
    // Number of rings of elements below the tool and outside it.
    int inner_rings = 0, outer_rings = 0;
    int rays = 0;  // elements in the sector's angle
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
  // Number of node columns through the plate, in the order of their elimination, with the clamped
  // ones last.
  [[nodiscard]] int columns() const { return static_cast<int>(places_.size()); }
  [[nodiscard]] int free_columns() const { return free_columns_; }
  [[nodiscard]] int column(int circle, int ray) const {
    const int i = circle == 0 ? 0 : 1 + (circle - 1) * ray_lines() + ray;
    return column_[static_cast<std::size_t>(i)];
  }
  [[nodiscard]] const Eigen::Vector2d& place(int column) const {
    return places_[static_cast<std::size_t>(column)];
  }
  // Columns of the element at (ring, ray): circle by circle outward, on each along the angle.
  [[nodiscard]] std::array<int, kElementColumns> element(int ring, int ray) const;
  // Returns the components of a column's displacement that the mirror planes fix.
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

// Elastic forces and stiffness of a thick plate of neo-Hookean rubber, without any kinematic
// assumption: cubic hexahedra over half of it or a quarter, between mirror planes.
class NeoHookeanDisc {
 public:
  using Matrix = NeoHookeanBody::Matrix;

  // Stores a reference to the mesh. -1 < nu < 0.5; `tension` at rest in the plate's plane, >= 0.
  NeoHookeanDisc(const DiscMesh& mesh, double nu, double tension = 0);

  // Unknowns: column by column of the mesh, upward, x, y, z.
  [[nodiscard]] int size() const { return body_.size(); }
  [[nodiscard]] int unknown(int column, int level, int component) const {
    return 3 * (mesh_.levels() * column + level) + component;
  }
  // Computes forces as NeoHookeanBody does. For components that the mirror planes fix, forces are
  // zero and the stiffness is one.
  bool Forces(const Eigen::VectorXd& u, Eigen::VectorXd* forces) const;
  bool Linearise(const Eigen::VectorXd& u, Eigen::VectorXd* forces, Matrix* stiffness) const;
  [[nodiscard]] Matrix EmptyMatrix() const { return body_.EmptyMatrix(); }
  // Returns the load of one along -z, spread evenly over the outer face below the tool.
  [[nodiscard]] Eigen::VectorXd ToolLoad() const;

 private:
  const DiscMesh& mesh_;
  NeoHookeanBody body_;
  Eigen::VectorXd free_;  // 0 for components that the mirror planes fix, else 1
};

}  // namespace palpate::simulation
