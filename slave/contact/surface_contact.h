// Contact of a fingertip with the object's mesh (paper B, III.B, equations 5 to 7).
#pragma once

#include <array>
#include <cstdint>
#include <optional>
#include <vector>

#include <Eigen/Core>

#include "shared/mesh/solid_mesh.h"
#include "slave/mesh/index.h"

namespace palpate {

struct TrianglePlace {
  // kEdge: between corners `corner` and `corner + 1` (mod 3). kCorner: corner `corner`.
  enum class Feature : std::uint8_t { kFace, kEdge, kCorner } feature = Feature::kFace;
  int corner = 0;
  Eigen::Vector3d p{0, 0, 0};        // [m]
  Eigen::Vector3d weights{0, 0, 0};  // of the corners, each 0 to 1, sum 1
  double distance_squared = 0;       // [m^2]
};

// The triangle's point closest to `p`; degenerate triangles are treated as segments or points. Two
// triangles that share an edge give bitwise equal results on it, if the edge runs from the same
// corner in both: `first_smaller` states for edge i whether corner i comes before corner i + 1.
TrianglePlace ClosestOnTriangle(const Eigen::Vector3d& p, const std::array<Eigen::Vector3d, 3>& abc,
                                const std::array<bool, 3>& first_smaller) noexcept;

// Where a point touches a surface. Frame O.
struct TouchedPlace {
  int triangle = -1;
  Eigen::Vector3d p_O{0, 0, 0};      // closest point of the surface at rest [m]
  Eigen::Vector3d n_O{0, 0, 0};      // outward unit normal of its triangle
  Eigen::Vector3d weights{0, 0, 0};  // of the triangle's three nodes, each 0 to 1, sum 1
  double distance = 0;               // [m], >= 0
  bool inside = false;               // the point is behind the surface
};

// Finds the closest point of a closed surface. Has its own search tree; const members are
// thread-safe and allocation-free. Among triangles that share the closest edge or node, it selects
// the one from whose plane the point is farthest.
class SurfaceContact {
 public:
  // O(N log N). Triangles without area are passed over. Throws std::invalid_argument: no triangle
  // has one, a node is missing or not finite.
  explicit SurfaceContact(SurfaceMesh surface);

  // Returns nullopt if the point is farther than `gate` [m] from the surface (paper B: 1 cm), or
  // not finite.
  [[nodiscard]] std::optional<TouchedPlace> Find(const Eigen::Vector3d& p_O,
                                                 double gate) const noexcept;
  [[nodiscard]] const SurfaceMesh& surface() const { return surface_; }

 private:
  struct Face {
    int triangle = -1;
    std::array<Eigen::Vector3d, 3> corners;
    std::array<bool, 3> first_smaller{};          // by node number, edge i to i + 1
    Eigen::Vector3d normal{0, 0, 0};              // unit
    std::array<Eigen::Vector3d, 3> edge_normals;  // not unit
  };
  struct Box {  // axis-aligned bounds; a leaf contains triangles, an inner box contains two boxes
    Eigen::Vector3d lower, upper;
    int begin, end;  // range of faces
    int left = -1, right = -1;
  };
  struct Candidate {
    int face = -1;
    TrianglePlace place;
    double height = 0;  // of the point over the face's plane [m], unsigned
  };

  void CheckNodes() const;
  void AddFaces();
  void AddNormals();
  int Build(int begin, int end);
  [[nodiscard]] double MinDistanceSquared(const Box& box, const Eigen::Vector3d& p) const noexcept;
  [[nodiscard]] Candidate Project(int face, const Eigen::Vector3d& p) const noexcept;
  [[nodiscard]] bool IsNearer(const Candidate& one, const Candidate& other) const noexcept;
  [[nodiscard]] const Eigen::Vector3d& PseudoNormal(const Candidate& candidate) const noexcept;
  [[nodiscard]] const Face& FaceAt(int i) const noexcept { return faces_[Index(i)]; }

  SurfaceMesh surface_;
  std::vector<Face>
      faces_;  // triangles with an area; the neighbours of one without area contain all its points
  std::vector<Box> boxes_;                     // boxes_[0] is the root
  std::vector<Eigen::Vector3d> node_normals_;  // not unit
  double reach_ = 0;                           // largest distance of a node from the origin [m]
};

}  // namespace palpate
