#include "slave/mesh/mesh_check.h"

#include <cmath>
#include <numbers>
#include <stdexcept>

#include <gmock/gmock.h>
#include <gtest/gtest.h>

namespace palpate {
namespace {

using Eigen::Vector3d;
using ::testing::Contains;
using ::testing::ElementsAre;
using ::testing::HasSubstr;
using ::testing::IsEmpty;

// Returns the numbers of a file that counts nodes from 1 and elements from 101.
MeshNumbers FileNumbers(const SolidMesh& mesh) {
  MeshNumbers numbers;
  for (std::size_t i = 0; i < mesh.nodes.size(); ++i) {
    numbers.nodes.push_back(static_cast<std::int64_t>(i) + 1);
  }
  for (std::size_t i = 0; i < mesh.tets.size(); ++i) {
    numbers.elements.push_back(static_cast<std::int64_t>(i) + 101);
  }
  return numbers;
}

SolidMesh BoxMesh() {
  return MeshBox({0.2, 0.04, 0.04}, {5, 2, 2});
}

// Reference: the box itself. The cells' tetrahedra have edges h (1, sqrt 2, sqrt 3) for cubes of
// side h: quality 6 sqrt(2) (h^3 / 6) / (sqrt(3) h)^3 = sqrt(2) / 3^1.5.
TEST(MeshCheckTest, MeasuresABox) {
  for (const double h : {1e-9, 0.02, 1e3}) {
    SolidMesh mesh = MeshBox({3 * h, 2 * h, 2 * h}, {3, 2, 2});
    const MeshReport report = CheckMesh(mesh, {}, true);
    EXPECT_THAT(report.refusals, IsEmpty());
    EXPECT_THAT(report.warnings, IsEmpty()) << h;
    EXPECT_EQ(report.nodes, 36);
    EXPECT_EQ(report.elements, 72);
    EXPECT_EQ(report.parts, 1);
    EXPECT_EQ(report.low_O, Vector3d::Zero());
    EXPECT_EQ(report.high_O, Vector3d(3 * h, 2 * h, 2 * h));
    EXPECT_NEAR(report.volume / (12 * h * h * h), 1, 1e-14);
    EXPECT_NEAR(report.area / (32 * h * h), 1, 1e-14);
    EXPECT_NEAR(report.quality_min, std::numbers::sqrt2 / std::pow(3, 1.5), 1e-14);
    EXPECT_NEAR(report.quality_median, report.quality_min, 1e-14);
    // Longest edge sqrt(3) h over the height on the face of area h^2 / sqrt 2: h / sqrt 2.
    EXPECT_NEAR(report.aspect_max, std::sqrt(6.0), 1e-13);
  }
}

TEST(MeshCheckTest, TurnsInvertedElementsRoundAndNamesThem) {
  const SolidMesh sound = BoxMesh();
  SolidMesh mesh = sound;
  for (const std::size_t t : {3U, 17U}) std::swap(mesh.tets[t][0], mesh.tets[t][1]);
  const MeshReport report = CheckMesh(mesh, FileNumbers(mesh));
  EXPECT_THAT(report.inverted, ElementsAre(3, 17));
  EXPECT_THAT(report.refusals, IsEmpty());
  EXPECT_THAT(report.warnings, ElementsAre(HasSubstr("2 inverted elements were turned round: "
                                                     "elements 104, 118")));
  for (int t = 0; t < static_cast<int>(mesh.tets.size()); ++t) EXPECT_GT(SignedVolume(mesh, t), 0);
}

// A flat element with a volume: a height of 1e-6 of the edges is a sliver; of 1e-15, rounding.
TEST(MeshCheckTest, DistinguishesSliversFromFlatElements) {
  const auto flat = [](double height) {
    return SolidMesh{{{0, 0, 0}, {1, 0, 0}, {0, 1, 0}, {0.3, 0.3, height}}, {{0, 1, 2, 3}}};
  };
  SolidMesh sliver = flat(1e-6), nothing = flat(1e-15);
  const MeshReport report = CheckMesh(sliver, FileNumbers(sliver));
  EXPECT_THAT(report.refusals, IsEmpty());
  EXPECT_THAT(report.slivers, ElementsAre(0));
  EXPECT_THAT(report.warnings, ElementsAre("1 slivers, quality below 0.05: element 101"));
  // 6 sqrt(2) (1e-6 / 6) / sqrt(2)^3 = 5e-7.
  EXPECT_NEAR(report.quality_min, 5e-7, 1e-12);
  EXPECT_THAT(CheckMesh(nothing).refusals, ElementsAre(HasSubstr("element 0 without volume")));
}

TEST(MeshCheckTest, FindsDuplicateNodes) {
  SolidMesh mesh = BoxMesh();
  mesh.nodes.push_back(mesh.nodes[4] + Vector3d::Constant(1e-11));
  mesh.tets.back()[3] = static_cast<int>(mesh.nodes.size()) - 1;
  mesh.nodes.back() =
      mesh.nodes[static_cast<std::size_t>(BoxMesh().tets.back()[3])] + Vector3d::Constant(1e-11);
  const MeshReport report = CheckMesh(mesh, FileNumbers(mesh));
  EXPECT_THAT(report.duplicate_nodes, ElementsAre(54));
  EXPECT_THAT(report.warnings, Contains(HasSubstr("1 duplicate nodes (node 55 lies at node ")));
}

// Remarks name the numbers of the file. An inverted element: the order of its nodes can be
// corrected, their positions cannot.
TEST(MeshCheckTest, SaysWhatItRefuses) {
  const auto refusals = [](SolidMesh mesh) {
    const MeshReport report = CheckMesh(mesh, FileNumbers(mesh), true);
    EXPECT_THROW(RequireSound(report), std::invalid_argument);
    return report.refusals;
  };
  for (const double size : {1e-9, 1.0, 1e3}) {
    SolidMesh flat = MeshBox({size, size, size}, {2, 2, 2});
    flat.tets[5][3] = flat.tets[5][0];
    flat.nodes[0] = flat.nodes[1];
    EXPECT_THAT(refusals(flat), Contains(HasSubstr("elements 101, 102, 106 without volume")));
  }
  SolidMesh twice = BoxMesh(), nan = BoxMesh(), out = BoxMesh(), negative = BoxMesh();
  twice.tets.push_back({twice.tets[2][1], twice.tets[2][0], twice.tets[2][3], twice.tets[2][2]});
  nan.nodes[3].y() = std::nan("");
  out.tets[7][2] = 54;
  negative.tets[7][0] = -1;
  const std::vector<Vector3d> nodes{{0, 0, 0}, {1, 0, 0}, {0, 1, 0}, {0, 0, 1}, {0.2, 0.2, 0.5}};
  EXPECT_THAT(refusals(twice),
              Contains(HasSubstr("element 221 has the nodes of element 103 (1 such)")));
  EXPECT_THAT(refusals({{nodes[0], nodes[1], nodes[2], nodes[3], {0, 0, -1}, {1, 1, 1}},
                        {{0, 1, 2, 3}, {0, 2, 1, 4}, {0, 1, 2, 5}}}),
              ElementsAre(HasSubstr("elements 101, 102, 103 share a face (1 such)")));
  EXPECT_THAT(refusals({nodes, {{0, 1, 2, 3}, {0, 2, 1, 4}}}),
              ElementsAre(HasSubstr(
                  "elements 101, 102 lie on the same side of their common face (1 such)")));
  EXPECT_THAT(refusals({}), ElementsAre(HasSubstr("no element")));
  EXPECT_THAT(refusals(nan), ElementsAre(HasSubstr("node 4 is not finite")));
  EXPECT_THAT(refusals(out), ElementsAre(HasSubstr("element 108 has a node that does not exist")));
  EXPECT_THAT(refusals(negative), ElementsAre(HasSubstr("element 108")));
}

}  // namespace
}  // namespace palpate
