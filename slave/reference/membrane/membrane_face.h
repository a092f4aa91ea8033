// The inner face of a deformed membrane: its nodes and interpolation between them.
#pragma once

#include <array>
#include <vector>

#include <Eigen/Core>

#include "slave/reference/membrane/neo_hookean_disc.h"

namespace palpate::simulation {

class MembraneFace {
 public:
  static constexpr int kNodes = DiscMesh::kElementColumns;  // of an element's face

  // The face of the whole plate, in frame O: the mesh's x axis points to `p_O`, lengths times
  // `unit` [m].
  MembraneFace(const DiscMesh& mesh, const Eigen::Vector2d& p_O, double unit);

  // Returns the nodes from the tool's centre, node 0, circle by circle outward, and
  // counter-clockwise on each circle from the ray to p_O.
  [[nodiscard]] std::vector<Eigen::Vector2d> Nodes() const;         // [m]
  [[nodiscard]] std::vector<std::array<int, 3>> Triangles() const;  // facing +z, nine per element
  // Source locates the displacements of a node in the mesh's sector: the rows of the column, and
  // the factors of x and y of the displacement there.
  struct Source {
    int circle = 0, ray = 0;
    double x = 1, y = 1;
  };
  [[nodiscard]] std::vector<Source> Sources() const;
  // Returns the vector in frame O, from its components in the mesh's frame.
  [[nodiscard]] Eigen::Vector3d Turned(const Eigen::Vector3d& v) const;

  // Shape functions that are not zero at a point [m], their sum 1. False: outside the rim.
  struct Stencil {
    std::array<int, kNodes> nodes{};
    std::array<double, kNodes> weights{};
  };
  bool Find(const Eigen::Vector2d& p_O, Stencil* stencil) const noexcept;

 private:
  [[nodiscard]] int node(int circle, int ray) const {
    return circle == 0 ? 0 : 1 + (circle - 1) * rays_ + ray % rays_;
  }
  [[nodiscard]] int circles() const { return static_cast<int>(s_.size()); }

  NestedCircles circles_;
  std::vector<double> s_;  // of the lines
  int rays_ = 0;           // lines, all around
  bool quarter_ = false;
  Eigen::Vector2d axis_{1, 0};
  double unit_ = 1;
};

}  // namespace palpate::simulation
