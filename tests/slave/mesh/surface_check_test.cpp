#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include "slave/mesh/mesh_check.h"
#include "tests/support/surfaces.h"

namespace palpate {
namespace {

using Eigen::Vector3d;
using ::testing::Contains;
using ::testing::ElementsAre;
using ::testing::HasSubstr;
using ::testing::IsEmpty;
using ::testing::SizeIs;

SurfaceMesh Cube(const Vector3d& low, double size) {
  return BoxSurface(low, Vector3d::Constant(size));
}

void TurnAll(SurfaceMesh* s) {
  for (auto& t : s->triangles) std::swap(t[0], t[1]);
}

TEST(SurfaceCheckTest, TurnsTrianglesOutward) {
  const SurfaceMesh sound = Cube({0, 0, 0}, 1);
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

// The normals of a cavity point into it, those of a body within the cavity point outwards, whatever
// their orientation in the file.
TEST(SurfaceCheckTest, TurnsCavitiesInward) {
  for (const bool inward : {false, true}) {
    SurfaceMesh cavity = Cube({1, 1, 1}, 4), body = Cube({2, 2, 2}, 2),
                outside = Cube({9, 1, 1}, 1);
    if (inward) TurnAll(&cavity), TurnAll(&body);
    SurfaceMesh s = Joined(Joined(body, cavity), Joined(outside, Cube({0, 0, 0}, 6)));
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

// Open at one triangle; the projective plane in six nodes, which is closed, every edge twice, and
// has no inside; triangles without area, and twice.
TEST(SurfaceCheckTest, RefusesWhatHasNoInside) {
  SurfaceMesh open = Cube({0, 0, 0}, 1), flat = open, twice = open;
  open.triangles.pop_back();
  flat.nodes[0] = flat.nodes[1];
  twice.triangles.push_back(twice.triangles[3]);
  SurfaceMesh one_sided{{{0, 0, 0}, {1, 0, 0}, {0, 1, 0}, {0, 0, 1}, {1, 1, 0.3}, {0.2, 1, 1}},
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
  const MeshReport opened = CheckMesh(open);
  EXPECT_EQ(opened.open_edges, 3);
  EXPECT_THAT(opened.refusals, ElementsAre(HasSubstr("the surface is open at 3 edges, the first: "
                                                     "element ")));
  SurfaceMesh apart = Cube({0, 0, 0}, 1);
  apart.nodes.push_back(apart.nodes[apart.triangles[0][0]]);
  apart.triangles[0][0] = static_cast<int>(apart.nodes.size()) - 1;
  EXPECT_THAT(CheckMesh(apart).refusals,
              Contains(HasSubstr("1 nodes have the position of another")));
  EXPECT_THAT(CheckMesh(one_sided).refusals, ElementsAre(HasSubstr("one-sided")));
  EXPECT_THAT(CheckMesh(flat).refusals[0], HasSubstr("without area"));
  EXPECT_THAT(CheckMesh(twice).refusals[0], HasSubstr("element 12 has the nodes of element 3"));
}

}  // namespace
}  // namespace palpate
