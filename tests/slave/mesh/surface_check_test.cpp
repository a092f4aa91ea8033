
#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include "slave/mesh/mesh_check.h"

namespace palpate {
namespace {

using Eigen::Vector3d;
using ::testing::ElementsAre;
using ::testing::HasSubstr;
using ::testing::IsEmpty;
using ::testing::SizeIs;

// A box's boundary with its nodes only.
SurfaceMesh Box(const Vector3d& low, double size) {
  SurfaceMesh s = SurfaceOf(MeshBox({size, size, size}, {1, 1, 1}));
  for (auto& p : s.nodes) p += low;
  return s;
}

SurfaceMesh Joined(const SurfaceMesh& a, const SurfaceMesh& b) {
  SurfaceMesh both = a;
  both.nodes.insert(both.nodes.end(), b.nodes.begin(), b.nodes.end());
  for (auto t : b.triangles) {
    for (int& i : t) i += static_cast<int>(a.nodes.size());
    both.triangles.push_back(t);
  }
  return both;
}

void TurnAll(SurfaceMesh* s) {
  for (auto& t : s->triangles) std::swap(t[0], t[1]);
}

TEST(SurfaceCheckTest, TurnsTrianglesOutward) {
  const SurfaceMesh sound = Box({0, 0, 0}, 1);
  SurfaceMesh some = sound, all = sound;
  std::swap(some.triangles[4][0], some.triangles[4][1]);
  std::swap(some.triangles[9][0], some.triangles[9][1]);
  TurnAll(&all);
  const MeshReport turned = CheckMesh(some), inward = CheckMesh(all);
  EXPECT_THAT(turned.inverted, ElementsAre(4, 9));
  EXPECT_THAT(inward.inverted, SizeIs(12));
  EXPECT_NEAR(turned.volume, 1, 1e-15);
  EXPECT_NEAR(inward.volume, 1, 1e-15);
}

// A cavity faces its inside, a body within the cavity outward again; whichever way they came.
TEST(SurfaceCheckTest, TurnsCavitiesInward) {
  for (const bool inward : {false, true}) {
    SurfaceMesh cavity = Box({1, 1, 1}, 4), body = Box({2, 2, 2}, 2), outside = Box({9, 1, 1}, 1);
    if (inward) TurnAll(&cavity), TurnAll(&body);
    SurfaceMesh s = Joined(Joined(body, cavity), Joined(outside, Box({0, 0, 0}, 6)));
    const MeshReport report = CheckMesh(s);
    EXPECT_THAT(report.refusals, IsEmpty());
    EXPECT_EQ(report.parts, 4);
    EXPECT_NEAR(report.volume, 216 - 64 + 8 + 1, 1e-12);
    const auto parts = ClosedParts(s);
    ASSERT_THAT(parts, SizeIs(4));
    EXPECT_EQ(parts[0].depth, 2);
    EXPECT_EQ(parts[1].depth, 1);
    EXPECT_EQ(parts[2].depth, 0);
    EXPECT_EQ(parts[3].depth, 0);
  }
}

TEST(SurfaceCheckTest, RefusesOpenSurfaces) {
  SurfaceMesh s = Box({0, 0, 0}, 1);
  s.triangles.pop_back();
  const MeshReport report = CheckMesh(s);
  EXPECT_EQ(report.open_edges, 3);
  EXPECT_THAT(report.refusals, ElementsAre(HasSubstr("the surface is open at 3 edges, the first: "
                                                     "element ")));
}

// The projective plane in six nodes: closed, every edge twice, without an inside.
TEST(SurfaceCheckTest, RefusesOneSidedSurfaces) {
  SurfaceMesh s{{{0, 0, 0}, {1, 0, 0}, {0, 1, 0}, {0, 0, 1}, {1, 1, 0.3}, {0.2, 1, 1}},
                {{0, 1, 4},
                 {0, 1, 5},
                 {0, 2, 3},
                 {0, 2, 5},
                 {0, 3, 4},
                 {1, 2, 3},
                 {1, 2, 4},
                 {1, 3, 5},
                 {2, 4, 5},
                 {3, 4, 5}}};
  EXPECT_THAT(CheckMesh(s).refusals, ElementsAre(HasSubstr("one-sided")));
}

TEST(SurfaceCheckTest, RefusesTrianglesWithoutAreaOrTwice) {
  SurfaceMesh flat = Box({0, 0, 0}, 1), twice = flat;
  flat.nodes[0] = flat.nodes[1];
  twice.triangles.push_back(twice.triangles[3]);
  EXPECT_THAT(CheckMesh(flat).refusals[0], HasSubstr("without area"));
  EXPECT_THAT(CheckMesh(twice).refusals[0], HasSubstr("element 12 has the nodes of element 3"));
}

}  // namespace
}  // namespace palpate
