// Tests writing: reading a written file must give the same mesh.
#include <array>
#include <cstdint>
#include <string>
#include <vector>

#include <gtest/gtest.h>

#include "shared/mesh/vtu_writer.h"
#include "slave/mesh/files/mesh_file.h"
#include "tests/support/scratch.h"
#include "tests/support/vtu_text.h"

namespace palpate {
namespace {

// Coordinates that need all 17 digits, at both ends of the lengths in use.
SolidMesh Awkward(double size) {
  SolidMesh mesh = MeshBox({size, size / 3, size / 7}, {3, 2, 2});
  for (auto& p : mesh.nodes) p += 0.1 * size * p.cwiseProduct(p) / (size * size);
  return mesh;
}

VtuGrid GridOf(const SolidMesh& mesh) {
  VtuGrid grid;
  grid.points = mesh.nodes;
  grid.tets = mesh.tets;
  return grid;
}

using MeshWritersTest = FolderTest;

std::vector<double> Flat(const std::vector<Eigen::Vector3d>& points) {
  std::vector<double> numbers;
  for (const auto& p : points) numbers.insert(numbers.end(), p.begin(), p.end());
  return numbers;
}

template <std::size_t kCorners>
std::vector<std::int64_t> Flat(const std::vector<std::array<int, kCorners>>& elements) {
  std::vector<std::int64_t> numbers;
  for (const auto& corners : elements)
    numbers.insert(numbers.end(), corners.begin(), corners.end());
  return numbers;
}

// Reference: the grid itself and VTK's numbers of cell types.
void ExpectVtu(const VtuGrid& grid) {
  const std::string file = ToVtu(grid);
  const bool solid = !grid.tets.empty();
  const std::size_t cells = solid ? grid.tets.size() : grid.triangles.size();
  EXPECT_EQ(VtuArray<double>(file, "type=\"Float64\""), Flat(grid.points));
  EXPECT_EQ(VtuArray<std::int64_t>(file, "Name=\"connectivity\""),
            solid ? Flat(grid.tets) : Flat(grid.triangles));
  const auto ends = VtuArray<std::int64_t>(file, "Name=\"offsets\"");
  ASSERT_EQ(ends.size(), cells);
  for (std::size_t i = 0; i < cells; ++i)
    EXPECT_EQ(ends[i], static_cast<std::int64_t>((solid ? 4U : 3U) * (i + 1)));
  EXPECT_EQ(VtuArray<std::uint8_t>(file, "Name=\"types\""),
            std::vector<std::uint8_t>(cells, solid ? 10 : 5));
}

TEST_F(MeshWritersTest, RoundTripEveryDigitOfASolid) {
  for (const double size : {1e-9, 0.06, 1e3}) {
    const SolidMesh mesh = Awkward(size);
    EXPECT_TRUE(WriteGmsh(folder_ / "a.msh", mesh));
    const auto read = std::get<SolidMesh>(ReadMeshFile(folder_ / "a.msh", 1).mesh);
    EXPECT_EQ(read.nodes, mesh.nodes) << size;
    EXPECT_EQ(read.tets, mesh.tets) << size;
    ExpectVtu(GridOf(mesh));
  }
}

TEST_F(MeshWritersTest, RoundTripASurface) {
  const SurfaceMesh mesh = SurfaceOf(MeshBox({0.3, 0.2, 0.1}, {2, 1, 1}));
  EXPECT_TRUE(WriteGmsh(folder_ / "a.msh", mesh));
  const auto read = std::get<SurfaceMesh>(ReadMeshFile(folder_ / "a.msh", 1).mesh);
  EXPECT_EQ(read.nodes, mesh.nodes);
  EXPECT_EQ(read.triangles, mesh.triangles);
  VtuGrid grid;
  grid.points = mesh.nodes;
  grid.triangles = mesh.triangles;
  ExpectVtu(grid);
}

TEST(VtuWriterTest, KeepsTheArraysOfEveryCase) {
  VtuGrid grid;
  grid.points = {{0, 0, 0}, {1, 0, 0}, {2, 0, 0}};
  grid.lines = {{0, 1}};
  const std::vector<double> a{1e-9, 0.1, 1.0 / 3, 4, 5, 6, 7, 8, -9e300};
  grid.arrays.push_back({CaseArrayName("displacement", "a", 2), 3, a});
  grid.arrays.push_back({CaseArrayName("stress", "b<\"&", 2), 1, {1, 2, 3}});
  const std::string file = ToVtu(grid);
  EXPECT_EQ(VtuArray<double>(file, "Name=\"displacement a\""), a);
  EXPECT_EQ(VtuArray<double>(file, "Name=\"stress b&lt;&quot;&amp;\""),
            (std::vector{1.0, 2.0, 3.0}));
  EXPECT_EQ(CaseArrayName("displacement", "only", 1), "displacement");
}

}  // namespace
}  // namespace palpate
