// Writing: what is read back is what was written.

#include <gtest/gtest.h>

#include "shared/mesh/files/mesh_file.h"
#include "shared/mesh/files/vtu_data.h"
#include "shared/mesh/files/vtu_writer.h"
#include "shared/mesh/files/xml.h"
#include "tests/support/scratch.h"

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

TEST_F(MeshWritersTest, RoundTripEveryDigitOfASolid) {
  for (const double size : {1e-9, 0.06, 1e3}) {
    const SolidMesh mesh = Awkward(size);
    EXPECT_TRUE(WriteGmsh(folder_ / "a.msh", mesh));
    EXPECT_TRUE(WriteVtu(folder_ / "a.vtu", GridOf(mesh), VtuForm::kAscii));
    EXPECT_TRUE(WriteVtu(folder_ / "b.vtu", GridOf(mesh), VtuForm::kAppended));
    for (const char* name : {"a.msh", "a.vtu", "b.vtu"}) {
      const auto read = std::get<SolidMesh>(ReadMeshFile(folder_ / name, 1).mesh);
      EXPECT_EQ(read.nodes, mesh.nodes) << name << " " << size;
      EXPECT_EQ(read.tets, mesh.tets) << name << " " << size;
    }
  }
}

TEST_F(MeshWritersTest, RoundTripASurface) {
  SurfaceMesh mesh = SurfaceOf(MeshBox({0.3, 0.2, 0.1}, {2, 1, 1}));
  EXPECT_TRUE(WriteGmsh(folder_ / "a.msh", mesh));
  VtuGrid grid;
  grid.points = mesh.nodes;
  grid.triangles = mesh.triangles;
  EXPECT_TRUE(WriteVtu(folder_ / "a.vtu", grid, VtuForm::kAppended));
  for (const char* name : {"a.msh", "a.vtu"}) {
    const auto read = std::get<SurfaceMesh>(ReadMeshFile(folder_ / name, 1).mesh);
    EXPECT_EQ(read.nodes, mesh.nodes) << name;
    EXPECT_EQ(read.triangles, mesh.triangles) << name;
  }
}

std::vector<double> ArrayOf(const std::filesystem::path& file, const std::string& name) {
  FileCursor cursor(file);
  const XmlElement root = ParseXml(&cursor, "AppendedData");
  VtuData data(&cursor, root);
  for (const XmlElement& array :
       root.Child("UnstructuredGrid")->Child("Piece")->Child("PointData")->children) {
    if (array.Attribute("Name") == name) return data.Reals(array, VtuData::kAny);
  }
  return {};
}

TEST(VtuWriterTest, KeepsTheArraysOfEveryCase) {
  const Scratch folder;
  VtuGrid grid;
  grid.points = {{0, 0, 0}, {1, 0, 0}, {2, 0, 0}};
  grid.lines = {{0, 1}};
  grid.vertices = {2};
  const std::vector<double> a{1e-9, 0.1, 1.0 / 3, 4, 5, 6, 7, 8, -9e300};
  grid.arrays.push_back({CaseArrayName("displacement", "a", 2), 3, a, {}});
  grid.arrays.push_back({CaseArrayName("stress", "b<\"&", 2), 1, {1, 2, 3}, {"xx"}});
  for (const VtuForm form : {VtuForm::kAscii, VtuForm::kAppended}) {
    ASSERT_TRUE(WriteVtu(folder / "a.vtu", grid, form));
    EXPECT_EQ(ArrayOf(folder / "a.vtu", "displacement a"), a);
    EXPECT_EQ(ArrayOf(folder / "a.vtu", "stress b&lt;&quot;&amp;"), (std::vector{1.0, 2.0, 3.0}));
  }
  EXPECT_EQ(CaseArrayName("displacement", "only", 1), "displacement");
}

TEST(VtuWriterTest, RefusesArraysThatDoNotFit) {
  const Scratch folder;
  VtuGrid grid = GridOf(Awkward(1));
  grid.arrays.push_back({"displacement", 3, {1, 2, 3}, {}});
  EXPECT_THROW(WriteVtu(folder / "a.vtu", grid, VtuForm::kAscii), std::invalid_argument);
}

TEST_F(MeshWritersTest, SayWhenTheyCannotWrite) {
  const SolidMesh mesh = Awkward(1);
  EXPECT_FALSE(WriteGmsh(folder_ / "no" / "a.msh", mesh));
  EXPECT_FALSE(WriteGmsh(folder_ / "no" / "a.msh", SurfaceOf(mesh)));
  EXPECT_FALSE(WriteVtu(folder_ / "no" / "a.vtu", GridOf(mesh), VtuForm::kAppended));
}

}  // namespace
}  // namespace palpate
