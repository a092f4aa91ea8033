#include <gtest/gtest.h>

#include "master/view/shape_layers.h"

namespace palpate {
namespace {

// Reference: of a cube's twelve edges the three at the hidden corner are not seen, however finely
// it is meshed; the diagonals and the lines within a face are none.
TEST(RestOutlineTest, OfACubeNineEdgesAreSeen) {
  const double side = 0.06;
  for (const int cells : {1, 4}) {
    const SurfaceMesh cube = SurfaceOf(MeshBox({side, side, side}, {cells, cells, cells}));
    const auto edges = VisibleOutline(cube, Viewpoint::Across({1, 0, 0}));
    double length = 0;
    for (const auto& [a, b] : edges) {
      length += (cube.nodes[static_cast<std::size_t>(a)] - cube.nodes[static_cast<std::size_t>(b)])
                    .norm();
    }
    EXPECT_EQ(edges.size(), 9U * static_cast<std::size_t>(cells));
    EXPECT_NEAR(length, 9 * side, 1e-12);
  }
}

TEST(RestOutlineTest, OfAnOpenSheetTheRimIsSeen) {
  SurfaceMesh sheet;
  sheet.nodes = {{0, 0, 0}, {1, 0, 0}, {1, 1, 0}, {0, 1, 0}};
  sheet.triangles = {{0, 1, 2}, {0, 2, 3}};
  EXPECT_EQ(VisibleOutline(sheet, Viewpoint::Across({1, 0, 0})).size(), 4U);
  EXPECT_TRUE(VisibleOutline({}, Viewpoint::Front()).empty());
}

}  // namespace
}  // namespace palpate
