// The foam objects of paper B: reading and checking must give the values in their README.
#include <filesystem>

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include "slave/mesh/files/mesh_file.h"
#include "slave/mesh/mesh_check.h"
#include "tests/support/paths.h"

namespace palpate {
namespace {

const std::filesystem::path kFolder = SourcePath("/../shared/data/seed001_meshes");

struct Measured {
  const char* name;
  int nodes, tets;
  Eigen::Vector3d size;
  double volume, quality_min, quality_median;
};

class SeedMeshesTest : public ::testing::TestWithParam<Measured> {};

// Reference: the table in seed001_meshes/README.md; three digits of quality.
TEST_P(SeedMeshesTest, MeasuresAsInTheTable) {
  if (!std::filesystem::exists(kFolder)) GTEST_SKIP() << "needs ../shared/data/seed001_meshes";
  const Measured& expected = GetParam();
  MeshFile file = ReadMeshFile(kFolder / (std::string(expected.name) + ".node"), 1);
  const MeshReport report = CheckMesh(std::get<SolidMesh>(file.mesh), file.numbers);
  EXPECT_EQ(report.nodes, expected.nodes);
  EXPECT_EQ(report.elements, expected.tets);
  EXPECT_LE((report.high_O - report.low_O - expected.size).norm(), 1e-15);
  EXPECT_NEAR(report.volume / expected.volume, 1, 1e-12);
  EXPECT_NEAR(report.quality_min, expected.quality_min, 5e-4);
  EXPECT_NEAR(report.quality_median, expected.quality_median, 5e-4);
  EXPECT_THAT(report.inverted, ::testing::IsEmpty());
  EXPECT_THAT(report.warnings, ::testing::IsEmpty());
  EXPECT_THAT(report.refusals, ::testing::IsEmpty());
  EXPECT_EQ(file.numbers.Element(0), "element 1");
}

INSTANTIATE_TEST_SUITE_P(
    Foam, SeedMeshesTest,
    ::testing::Values(Measured{"bar", 152, 385, {0.2, 0.04, 0.04}, 0.00032, 0.180, 0.416},
                      Measured{"bar_long", 207, 536, {0.5, 0.06, 0.06}, 0.0018, 0.195, 0.417},
                      Measured{"cube", 153, 486, {0.06, 0.06, 0.06}, 0.000216, 0.174, 0.380},
                      Measured{"sponge", 118, 304, {0.08, 0.05, 0.02}, 8e-05, 0.203, 0.426}),
    [](const auto& mesh) { return std::string(mesh.param.name); });

}  // namespace
}  // namespace palpate
