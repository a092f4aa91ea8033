// Triangles of guaranteed quality, as small as a size field requires: Delaunay refinement after
// Ruppert, "A Delaunay refinement algorithm for quality 2-dimensional mesh generation", J.
// Algorithms 18 (1995). Coordinates of order one.
#pragma once

#include <array>
#include <vector>

#include <Eigen/Core>

namespace palpate {

// A straight piece of the boundary between two points. `tag` is the caller's; halves inherit it.
struct MeshSegment {
  int a = 0, b = 0;
  int tag = 0;
};

// Requested edge length: `largest` far away, `seed.size + growth * distance` around each seed.
struct SizeField {
  struct Seed {
    Eigen::Vector2d place;
    double size;
  };
  double largest = 0.1;
  double growth = 0.4;  // < 1
  std::vector<Seed> seeds;

  [[nodiscard]] double At(const Eigen::Vector2d& p) const;
};

struct TriangleMesh {
  std::vector<Eigen::Vector2d> points;
  std::vector<std::array<int, 3>> triangles;   // counter-clockwise
  std::vector<std::array<int, 3>> neighbours;  // behind the edge opposite vertex i; -1: boundary
  std::vector<MeshSegment> boundary;           // every boundary edge once, with its tag
};

// Meshes the area inside the closed loops of `segments`. No angle is below 20 degrees unless the
// outline itself has sharper corners. Throws std::runtime_error: crossing or open loops, coinciding
// points, more than `max_points`.
TriangleMesh MakeGradedMesh(const std::vector<Eigen::Vector2d>& points,
                            const std::vector<MeshSegment>& segments, const SizeField& size,
                            int max_points = 60000);

// Delaunay's triangles of the points, counter-clockwise: dual to their Voronoi diagram, which is
// exact for the points rounded to a raster of a billionth of their extent. Slivers between points
// on a line may be among them.
std::vector<std::array<int, 3>> DelaunayTriangles(const std::vector<Eigen::Vector2d>& points);

// Sum of the triangles' areas.
double Area(const TriangleMesh& mesh);
// Twice the signed area of a, b, c; positive counter-clockwise.
double Orientation(const Eigen::Vector2d& a, const Eigen::Vector2d& b, const Eigen::Vector2d& c);

}  // namespace palpate
