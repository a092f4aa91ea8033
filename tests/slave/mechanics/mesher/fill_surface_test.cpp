// Tests filling surfaces with the installed programs; tests whose program is missing are skipped.
#include "slave/mechanics/mesher/fill_surface.h"

#include <cmath>
#include <numbers>

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include "slave/mesh/mesh_check.h"
#include "slave/program/progress.h"
#include "slave/program/run_program.h"
#include "tests/slave/mechanics/mesher/path_guard.h"
#include "tests/support/scratch.h"
#include "tests/support/surfaces.h"
#include "tests/support/thrown.h"

namespace palpate {
namespace {

using Eigen::Vector3d;
using ::testing::HasSubstr;
using ::testing::IsEmpty;
using ::testing::SizeIs;
using Program = FillOptions::Program;

// Pushed in from a side it would cut itself: two boxes that overlap.
SurfaceMesh Crossing() {
  return Joined(BoxSurface({0, 0, 0}, {1, 1, 1}), BoxSurface({0.5, 0.3, 0.2}, {1, 1, 1}));
}

std::string Failure(const SurfaceMesh& surface, const FillOptions& options) {
  return Thrown<std::exception>([&] { FillSurface(surface, options); });
}

class FillSurfaceTest : public ::testing::TestWithParam<Program> {
 protected:
  void SetUp() override {
    const char* const name = GetParam() == Program::kTetgen ? "tetgen" : "gmsh";
    if (!FindProgram(name)) GTEST_SKIP() << "needs the program " << name;
    options_.program = GetParam();
  }
  FillOptions options_;
};

// Reference: the box's own volume. Asked for edges of a tenth of its side, TetGen makes no
// tetrahedron larger than a regular one of that edge; Gmsh keeps to the length on average, with
// tetrahedra up to a fourth longer on average, 1.26^3 = 2.
TEST_P(FillSurfaceTest, FillsABoxAtTheResolutionAskedForAndAtEverySize) {
  for (const double size : {1e-9, 0.06, 1e3}) {
    options_.resolution = 0.1 * size;
    SolidMesh mesh = FillSurface(BoxSurface({size, 0, 0}, {size, size, 0.5 * size}), options_);
    const MeshReport report = CheckMesh(mesh, {}, true);
    EXPECT_THAT(report.refusals, IsEmpty());
    EXPECT_THAT(report.dangling_nodes, IsEmpty());
    EXPECT_THAT(report.inverted, IsEmpty());
    EXPECT_NEAR(report.volume / (0.5 * std::pow(size, 3)), 1, 1e-9);
    EXPECT_LE((report.low_O - Vector3d(size, 0, 0)).norm(), 1e-12 * size);
    const double regular = std::pow(0.1 * size, 3) / (6 * std::numbers::sqrt2);
    double largest = 0;
    for (int t = 0; t < report.elements; ++t) largest = std::max(largest, SignedVolume(mesh, t));
    if (GetParam() == Program::kTetgen) {
      EXPECT_LE(largest, (1 + 1e-9) * regular);
    }
    EXPECT_GT(report.elements,
              (GetParam() == Program::kTetgen ? 1 : 0.5) * report.volume / regular);
  }
}

TEST_P(FillSurfaceTest, LeavesCavitiesEmpty) {
  for (const double resolution : {0.5, 0.0}) {
    options_.resolution = resolution;
    // Outward normals; must be reversed.
    const SurfaceMesh inner = BoxSurface({1, 1, 1}, {1, 1, 1});
    SolidMesh mesh = FillSurface(Joined(BoxSurface({0, 0, 0}, {3, 3, 3}), inner), options_);
    EXPECT_NEAR(CheckMesh(mesh).volume, 26, 0.26);
    for (const auto& tet : mesh.tets) {
      Vector3d centre = Vector3d::Zero();
      for (const int i : tet) centre += 0.25 * mesh.nodes[static_cast<std::size_t>(i)];
      EXPECT_GE((centre - Vector3d::Constant(1.5)).cwiseAbs().maxCoeff(), 0.5);
    }
  }
}

TEST_P(FillSurfaceTest, RefusesASurfaceThatCutsItselfInTheProgramsWords) {
  options_.resolution = 0.3;
  options_.timeout = std::chrono::seconds(20);
  const std::string failure = Failure(Crossing(), options_);
  if (GetParam() == Program::kTetgen) {
    EXPECT_THAT(failure, HasSubstr("intersect"));
  } else {
    EXPECT_THAT(failure, ::testing::AnyOf(HasSubstr("intersect"), HasSubstr("unusable")));
  }
}

INSTANTIATE_TEST_SUITE_P(Programs, FillSurfaceTest,
                         ::testing::Values(Program::kTetgen, Program::kGmsh),
                         [](const auto& program) {
                           return program.param == Program::kTetgen ? "tetgen" : "gmsh";
                         });

// TetGen keeps the surface's nodes, so that node numbers remain valid.
TEST(FillSurfaceByTetgenTest, KeepsTheNodesOfTheSurface) {
  if (!FindProgram("tetgen")) GTEST_SKIP() << "needs the program tetgen";
  const SurfaceMesh surface = Refined(Refined(BoxSurface({0, 0, 0}, {0.01, 0.02, 0.01})));
  const SolidMesh mesh = FillSurface(surface, {});
  ASSERT_GE(mesh.nodes.size(), surface.nodes.size());
  for (std::size_t i = 0; i < surface.nodes.size(); ++i) {
    EXPECT_LE((mesh.nodes[i] - surface.nodes[i]).norm(), 1e-16) << i;
  }
}

// Surfaces without an inside, invalid or too fine resolutions, and a missing mesher program.
TEST(FillSurfaceRefusalTest, SaysWhatItRefuses) {
  const SurfaceMesh box = BoxSurface({0, 0, 0}, {1, 1, 1});
  SurfaceMesh open = box;
  open.triangles.pop_back();
  EXPECT_THAT(Failure(open, {}), HasSubstr("the surface is open at 3 edges"));
  EXPECT_THAT(Failure({}, {}), HasSubstr("no element"));
  for (const double resolution : {-0.1, 1e-9, std::nan(""), HUGE_VAL}) {
    FillOptions options;
    options.resolution = resolution;
    // cbrt(6 sqrt(2) / 4e6).
    EXPECT_THAT(Failure(box, options), HasSubstr("expected 0, or at least 0.01285 m"));
  }
  if (FindProgram("gmsh")) {
    FillOptions options;
    options.program = Program::kGmsh;
    EXPECT_THAT(Failure(Joined(box, BoxSurface({2, 0, 0}, {1, 1, 1})), options),
                HasSubstr("2 closed parts beside each other"));
  }
  const PathGuard nowhere("/nowhere");
  EXPECT_THAT(Failure(box, {}),
              HasSubstr("expected one of the packages tetgen and gmsh to be installed "
                        "(deploy/install.sh mesher)"));
}

// Replaces the real program by faulty ones.
class FakeMesherTest : public ::testing::Test {
 protected:
  std::string FailureOf(const std::string& script) {
    const auto file = folder_.Write("tetgen", "#!/bin/sh\n" + script);
    std::filesystem::permissions(file, std::filesystem::perms::owner_all);
    const PathGuard path((folder_ / "").string() + ":/bin:/usr/bin");
    FillOptions options;
    options.program = Program::kTetgen;
    options.timeout = std::chrono::milliseconds(2000);
    return Failure(BoxSurface({0, 0, 0}, {1, 1, 1}), options);
  }
  Scratch folder_;
};

TEST_F(FakeMesherTest, SaysWhatItDidWrong) {
  EXPECT_THAT(FailureOf("echo out of   luck; exit 7\n"), HasSubstr("out of luck"));
  EXPECT_THAT(FailureOf("sleep 100\n"), HasSubstr("took longer than 2000 ms and was stopped"));
  EXPECT_THAT(FailureOf("echo nonsense > in.1.node; echo > in.1.ele\n"),
              HasSubstr("wrote a file that cannot be read"));
  EXPECT_THAT(FailureOf("echo '4 3 0 0\n0 0 0 0\n1 1 0 0\n2 0 1 0\n3 0 0 1' > in.1.node\n"
                        "echo '1 4 0\n0 0 1 2 3' > in.1.ele\n"),
              HasSubstr("filled another volume"));
}

TEST_F(FakeMesherTest, LeavesNoFolderBehind) {
  const Scratch temporary;
  setenv("TMPDIR", (temporary / "").c_str(), 1);
  FailureOf("exit 1\n");
  unsetenv("TMPDIR");
  EXPECT_TRUE(std::filesystem::is_empty(temporary / ""));
}

// A shell around a curved cavity: the point lies inside the cavity.
TEST(HolePointsTest, LieInsideEveryCavity) {
  SurfaceMesh s =
      Joined(Joined(BoxSurface({0, 0, 0}, {9, 9, 9}), BoxSurface({1, 1, 1}, {1, 7, 1})),
             Joined(BoxSurface({4, 1, 1}, {4, 4, 4}), BoxSurface({5, 2, 2}, {2, 2, 2})));
  CheckMesh(s);
  const auto points = HolePoints(s);
  ASSERT_THAT(points, SizeIs(2));
  const auto within = [](const Vector3d& p, const Vector3d& low, const Vector3d& high) {
    return (p - low).minCoeff() > 0 && (high - p).minCoeff() > 0;
  };
  EXPECT_TRUE(within(points[0], {1, 1, 1}, {2, 8, 2}));
  EXPECT_TRUE(within(points[1], {4, 1, 1}, {8, 5, 5}));
  EXPECT_FALSE(within(points[1], {5, 2, 2}, {7, 4, 4}));
}

}  // namespace
}  // namespace palpate
