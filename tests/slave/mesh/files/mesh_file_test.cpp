// Tests reading: the same mesh from every format and variant, and special properties of formats.
#include "slave/mesh/files/mesh_file.h"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include "tests/shared/mesh/files/all_samples.h"
#include "tests/support/scratch.h"
#include "tests/support/thrown.h"

namespace palpate {
namespace {

using ::testing::ElementsAre;
using ::testing::HasSubstr;

template <class Mesh>
void ExpectSameNodes(const Mesh& read, const Mesh& expected, double unit) {
  ASSERT_EQ(read.nodes.size(), expected.nodes.size());
  for (std::size_t i = 0; i < read.nodes.size(); ++i) {
    EXPECT_EQ(read.nodes[i], expected.nodes[i] * unit) << "node " << i;
  }
}

using MeshFileTest = FolderTest;

// Reference: the mesh the samples were written from; its coordinates are floats, so every form
// holds them exactly.
TEST_F(MeshFileTest, ReadsTheSameSolidFromEveryFormAndFormat) {
  for (const auto& sample : samples::Solids()) {
    SCOPED_TRACE(sample.name);
    const MeshFile read = ReadMeshFile(Write(sample.file, sample.bytes), 0.5);
    ASSERT_TRUE(std::holds_alternative<SolidMesh>(read.mesh));
    const auto& mesh = std::get<SolidMesh>(read.mesh);
    ExpectSameNodes(mesh, samples::Pair(), 0.5);
    EXPECT_EQ(mesh.tets, samples::Pair().tets);
  }
}

// STL has no node numbers: the corners are in the order of the triangles.
TEST_F(MeshFileTest, ReadsTheSameSurfaceFromEveryFormAndFormat) {
  const SurfaceMesh expected = samples::Tetrahedron();
  for (const auto& sample : samples::Surfaces()) {
    SCOPED_TRACE(sample.name);
    const MeshFile read = ReadMeshFile(Write(sample.file, sample.bytes), 1e-3);
    ASSERT_TRUE(std::holds_alternative<SurfaceMesh>(read.mesh));
    const auto& mesh = std::get<SurfaceMesh>(read.mesh);
    ASSERT_EQ(mesh.nodes.size(), 4U);
    ASSERT_EQ(mesh.triangles.size(), 4U);
    for (std::size_t t = 0; t < 4; ++t) {
      for (std::size_t i = 0; i < 3; ++i) {
        EXPECT_EQ(mesh.nodes[static_cast<std::size_t>(mesh.triangles[t][i])],
                  expected.nodes[static_cast<std::size_t>(expected.triangles[t][i])] * 1e-3);
      }
    }
  }
}

TEST_F(MeshFileTest, ReadsTetgensPairByEitherNameAndNumbering) {
  for (const int first : {0, 1}) {
    Write("pair.node", samples::Node(samples::Pair(), first));
    Write("pair.ele", samples::Ele(samples::Pair(), first));
    for (const char* name : {"pair.node", "pair.ele"}) {
      const MeshFile read = ReadMeshFile(folder_ / name, 1);
      EXPECT_EQ(std::get<SolidMesh>(read.mesh).tets, samples::Pair().tets) << name << first;
      EXPECT_EQ(read.numbers.Node(2), first == 0 ? "node 2" : "node 3");
      EXPECT_EQ(read.numbers.Element(1), first == 0 ? "element 1" : "element 2");
    }
  }
}

// A tetrahedron of ten nodes whose mid-edge nodes are numbered among the corners.
TEST_F(MeshFileTest, UsesTheCornersOfQuadraticElements) {
  const auto file = Write(
      "a.msh",
      "$MeshFormat\n2.2 0 8\n$EndMeshFormat\n$Nodes\n10\n1 0 0 0\n5 .5 0 0\n2 1 0 0\n6 .5 .5 0\n"
      "3 0 1 0\n7 0 .5 0\n4 0 0 1\n8 0 0 .5\n9 0 .5 .5\n10 .5 0 .5\n$EndNodes\n$Elements\n1\n"
      "1 11 2 0 1 1 2 3 4 5 6 7 8 9 10\n$EndElements\n");
  const MeshFile read = ReadMeshFile(file, 1);
  const auto& mesh = std::get<SolidMesh>(read.mesh);
  ASSERT_EQ(mesh.nodes.size(), 4U);
  EXPECT_EQ(mesh.nodes[3], Eigen::Vector3d(0, 0, 1));
  EXPECT_THAT(mesh.tets, ElementsAre(ElementsAre(0, 1, 2, 3)));
  EXPECT_EQ(read.numbers.Node(3), "node 4");
  EXPECT_THAT(read.remarks, ElementsAre(HasSubstr("6 nodes in the middle")));
}

TEST_F(MeshFileTest, CutsQuadrilateralsAlongTheShorterDiagonal) {
  const auto file = Write("a.ply",
                          "ply\nformat ascii 1.0\nelement vertex 4\nproperty float x\n"
                          "property float y\nproperty float z\nelement face 1\nproperty "
                          "list uchar int vertex_indices\nend_header\n0 0 0\n2 -1 0\n4 0 "
                          "0\n2 1 0\n4 0 1 2 3\n");
  const MeshFile read = ReadMeshFile(file, 1);
  EXPECT_THAT(std::get<SurfaceMesh>(read.mesh).triangles,
              ElementsAre(ElementsAre(0, 1, 3), ElementsAre(1, 2, 3)));
  EXPECT_THAT(read.remarks, ElementsAre(HasSubstr("1 quadrilaterals")));
}

// Corners that differ by a float's rounding are one node; triangles that become degenerate by
// merging are dropped.
TEST_F(MeshFileTest, MergesCornersThatDifferByRoundingOnly) {
  std::string text = samples::StlText(samples::Tetrahedron());
  text.replace(text.find("1.5"), 3, "1.50000012");
  text.insert(text.find("endsolid"),
              "facet normal 0 0 0 outer loop vertex 0 0 0 vertex 1e-9 0 0 vertex 1 0 0 endloop "
              "endfacet\n");
  const MeshFile read = ReadMeshFile(Write("a.stl", text), 1);
  EXPECT_EQ(std::get<SurfaceMesh>(read.mesh).nodes.size(), 4U);
  EXPECT_EQ(std::get<SurfaceMesh>(read.mesh).triangles.size(), 4U);
  EXPECT_THAT(read.remarks, ElementsAre(HasSubstr("1 triangles of no width")));
}

// Reference: the same triangles in the usual spelling.
TEST_F(MeshFileTest, RecognisesAnStlByItsContent) {
  const std::string text = samples::StlText(samples::Tetrahedron());
  std::string capitals = text;
  for (char& c : capitals) c = static_cast<char>(std::toupper(c));
  std::string returns = text;
  std::ranges::replace(returns, '\n', '\r');
  const auto triangles =
      std::get<SurfaceMesh>(ReadMeshFile(Write("a.stl", text), 1).mesh).triangles;
  for (const std::string& same : {capitals, "\r\n" + text, "\xEF\xBB\xBF" + text, returns}) {
    const MeshFile read = ReadMeshFile(Write("A.STL", same), 1);
    EXPECT_EQ(std::get<SurfaceMesh>(read.mesh).triangles, triangles) << same;
  }
}

// Some programs write separate vertices for every face; without merging, the surface would seem
// open.
TEST_F(MeshFileTest, MergesAPlysVerticesAtTheSamePlace) {
  SurfaceMesh apart;
  const SurfaceMesh whole = samples::Tetrahedron();
  for (const auto& t : whole.triangles) {
    const int first = static_cast<int>(apart.nodes.size());
    for (const int i : t) apart.nodes.push_back(whole.nodes[static_cast<std::size_t>(i)]);
    apart.triangles.push_back({first, first + 1, first + 2});
  }
  const MeshFile read =
      ReadMeshFile(Write("a.ply", samples::Ply(apart, "binary_little_endian")), 1);
  EXPECT_EQ(std::get<SurfaceMesh>(read.mesh).nodes.size(), 4U);
  EXPECT_EQ(std::get<SurfaceMesh>(read.mesh).triangles[1], (std::array{0, 2, 3}));
  EXPECT_THAT(read.remarks, ElementsAre(HasSubstr("8 vertices coincide with others")));
}

}  // namespace
}  // namespace palpate
