#include "shared/mesh/solid_mesh.h"

#include <limits>
#include <map>
#include <set>
#include <stdexcept>

#include <Eigen/Geometry>
#include <gtest/gtest.h>

namespace palpate {
namespace {

using Eigen::Vector3d;

double Volume(const SolidMesh& mesh) {
  double volume = 0;
  for (int t = 0; t < static_cast<int>(mesh.tets.size()); ++t) volume += SignedVolume(mesh, t);
  return volume;
}

Vector3d NodeAt(const SurfaceMesh& surface, int node) {
  return surface.nodes[static_cast<std::size_t>(node)];
}

// Sum of the triangles' vector areas, zero for a closed surface, and the volume by the divergence
// theorem.
struct Enclosed {
  Vector3d area{0, 0, 0};
  double volume = 0;
};
Enclosed EnclosedBy(const SurfaceMesh& surface) {
  Enclosed enclosed;
  for (const auto& [a, b, c] : surface.triangles) {
    const Vector3d p = NodeAt(surface, a), q = NodeAt(surface, b), r = NodeAt(surface, c);
    enclosed.area += 0.5 * (q - p).cross(r - p);
    enclosed.volume += p.dot(q.cross(r)) / 6;
  }
  return enclosed;
}

// Returns whether every directed edge occurs once in each direction.
bool IsClosed(const SurfaceMesh& surface) {
  std::map<std::pair<int, int>, int> uses;
  for (const auto& t : surface.triangles) {
    for (std::size_t i = 0; i < 3; ++i) ++uses[{t[i], t[(i + 1) % 3]}];
  }
  for (const auto& [edge, count] : uses) {
    if (count != 1 || !uses.contains({edge.second, edge.first})) return false;
  }
  return true;
}

// Reference: the rule of the cases cube_n*: id = i + (n+1)(j + (n+1)k), six tetrahedra per cell on
// the corners listed there, c = dx + 2 dy + 4 dz, the last two swapped where the volume is
// negative. The list's triple products are +1, -1, -1, +1, +1, -1.
TEST(MeshBoxTest, FollowsTheRuleOfTheReferenceCubes) {
  const std::array<std::array<int, 4>, 6> rule{
      {{0, 1, 3, 7}, {0, 1, 7, 5}, {0, 2, 7, 3}, {0, 2, 6, 7}, {0, 4, 5, 7}, {0, 4, 7, 6}}};
  const int n = 3;
  const double L = 0.06;
  const SolidMesh mesh = MeshBox({L, L, L}, {n, n, n});
  ASSERT_EQ(mesh.nodes.size(), 64U);
  ASSERT_EQ(mesh.tets.size(), 162U);
  std::size_t tet = 0;
  for (int k = 0; k < n; ++k) {
    for (int j = 0; j < n; ++j) {
      for (int i = 0; i < n; ++i) {
        const auto id = [&](int c) {
          return i + (c & 1) + (n + 1) * (j + (c >> 1 & 1) + (n + 1) * (k + (c >> 2)));
        };
        EXPECT_LE((mesh.nodes[static_cast<std::size_t>(id(0))] - L / n * Vector3d(i, j, k)).norm(),
                  1e-16);
        std::set<std::set<int>> expected, found;
        for (const auto& corners : rule) {
          std::set<int> nodes;
          for (const int c : corners) nodes.insert(id(c));
          expected.insert(nodes);
          found.insert(std::set<int>(mesh.tets[tet].begin(), mesh.tets[tet].end()));
          EXPECT_GT(SignedVolume(mesh, static_cast<int>(tet)), 0);
          ++tet;
        }
        EXPECT_EQ(found, expected);
      }
    }
  }
}

TEST(MeshBoxTest, FillsTheBoxAtEverySizeAndAspect) {
  for (const Vector3d& size :
       {Vector3d(1e-9, 2e-9, 3e-9), Vector3d(1e3, 1, 1e-3), Vector3d(0.2, 0.04, 0.04)}) {
    const SolidMesh mesh = MeshBox(size, {4, 3, 2});
    EXPECT_NEAR(Volume(mesh) / size.prod(), 1, 1e-14);
    EXPECT_NEAR(Diagonal(mesh.nodes) / size.norm(), 1, 1e-15);
    EXPECT_EQ(mesh.nodes.back(), size);
  }
}

TEST(MeshBoxTest, RefusesWhatIsNoBox) {
  const double nan = std::numeric_limits<double>::quiet_NaN();
  EXPECT_THROW(MeshBox({0, 1, 1}, {1, 1, 1}), std::invalid_argument);
  EXPECT_THROW(MeshBox({1, nan, 1}, {1, 1, 1}), std::invalid_argument);
  EXPECT_THROW(MeshBox({1, 1, 1}, {1, 0, 1}), std::invalid_argument);
  EXPECT_THROW(MeshBox({1, 1, 1}, {100, 100, 100}), std::invalid_argument);
  EXPECT_THROW(MeshBox({1, 1, 1}, {2147483647, 2147483647, 2147483647}), std::invalid_argument);
}

// Reference: the divergence theorem; a box's sides have two triangles per cell face.
TEST(SurfaceOfTest, IsClosedOutwardAndCompleteOnABox) {
  const SolidMesh mesh = MeshBox({0.3, 0.2, 0.1}, {4, 3, 2});
  const SurfaceMesh surface = SurfaceOf(mesh);
  EXPECT_EQ(surface.triangles.size(), 2U * 2 * (4 * 3 + 3 * 2 + 2 * 4));
  EXPECT_EQ(surface.nodes, mesh.nodes);
  EXPECT_TRUE(IsClosed(surface));
  const Enclosed enclosed = EnclosedBy(surface);
  EXPECT_LE(enclosed.area.norm(), 1e-17);
  EXPECT_NEAR(enclosed.volume, 0.006, 1e-17);
}

// A box without its central cell has two boundaries; the normals of the inner one point into the
// hole.
TEST(SurfaceOfTest, HasTheBoundaryOfACavityToo) {
  SolidMesh mesh = MeshBox({3, 3, 3}, {3, 3, 3});
  mesh.tets.erase(mesh.tets.begin() + 6 * 13, mesh.tets.begin() + 6 * 14);
  const SurfaceMesh surface = SurfaceOf(mesh);
  EXPECT_EQ(surface.triangles.size(), 108U + 12U);
  EXPECT_TRUE(IsClosed(surface));
  EXPECT_NEAR(EnclosedBy(surface).volume, 26, 1e-13);
}

SolidMesh Skewed() {
  SolidMesh mesh = MeshBox({1, 0.5, 0.3}, {2, 2, 1});
  for (auto& p : mesh.nodes) p += Vector3d(0.2 * p.y() * p.z(), 0.1 * p.x() * p.x(), 0.3 * p.x());
  return mesh;
}

TEST(RefinedTest, KeepsVolumeOrientationAndOldNodes) {
  const SolidMesh coarse = Skewed();
  const SolidMesh fine = Refined(coarse);
  ASSERT_EQ(fine.tets.size(), 8 * coarse.tets.size());
  for (std::size_t i = 0; i < coarse.nodes.size(); ++i) EXPECT_EQ(fine.nodes[i], coarse.nodes[i]);
  for (int t = 0; t < static_cast<int>(fine.tets.size()); ++t) {
    EXPECT_NEAR(SignedVolume(fine, t) / SignedVolume(coarse, t / 8), 0.125, 1e-13) << t;
  }
  EXPECT_NEAR(Volume(fine), Volume(coarse), 1e-15);
}

// Neighbouring elements are divided at the same midpoints, so that no gap opens.
TEST(RefinedTest, StaysJoined) {
  const SolidMesh coarse = Skewed();
  const SurfaceMesh surface = SurfaceOf(Refined(coarse));
  EXPECT_EQ(surface.triangles.size(), 4 * SurfaceOf(coarse).triangles.size());
  EXPECT_TRUE(IsClosed(surface));
}

}  // namespace
}  // namespace palpate
