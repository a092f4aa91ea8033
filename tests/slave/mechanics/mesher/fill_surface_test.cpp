// Filling surfaces by the installed programs; without one, the tests that need it are skipped.
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
#include "tests/support/thrown.h"

namespace palpate {
namespace {

using Eigen::Vector3d;
using ::testing::HasSubstr;
using ::testing::IsEmpty;
using ::testing::SizeIs;
using Program = FillOptions::Program;

SurfaceMesh Box(const Vector3d& low, const Vector3d& size) {
  SurfaceMesh s = SurfaceOf(MeshBox(size, {1, 1, 1}));
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

// An octahedron refined and pushed onto the sphere.
SurfaceMesh Sphere(double radius) {
  SurfaceMesh s{
      {{1, 0, 0}, {-1, 0, 0}, {0, 1, 0}, {0, -1, 0}, {0, 0, 1}, {0, 0, -1}},
      {{0, 2, 4}, {2, 1, 4}, {1, 3, 4}, {3, 0, 4}, {2, 0, 5}, {1, 2, 5}, {3, 1, 5}, {0, 3, 5}}};
  for (int i = 0; i < 3; ++i) {
    s = Refined(s);
    for (auto& p : s.nodes) p.normalize();
  }
  for (auto& p : s.nodes) p *= radius;
  return s;
}

// Pushed in from a side it would cut itself: two boxes that overlap.
SurfaceMesh Crossing() {
  return Joined(Box({0, 0, 0}, {1, 1, 1}), Box({0.5, 0.3, 0.2}, {1, 1, 1}));
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
    SolidMesh mesh = FillSurface(Box({size, 0, 0}, {size, size, 0.5 * size}), options_);
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

// The sphere's edges are up to 0.31 long: Gmsh keeps it at the first and divides it anew at the
// others.
TEST_P(FillSurfaceTest, GetsFinerWithTheResolution) {
  std::size_t last = 0;
  for (const double resolution : {0.4, 0.15, 0.11}) {
    options_.resolution = resolution;
    const SolidMesh mesh = FillSurface(Sphere(1), options_);
    EXPECT_GT(mesh.tets.size(), 1.2 * static_cast<double>(last)) << resolution;
    last = mesh.tets.size();
  }
}

TEST_P(FillSurfaceTest, LeavesCavitiesEmpty) {
  for (const double resolution : {0.5, 0.0}) {
    options_.resolution = resolution;
    SurfaceMesh inner = Box({1, 1, 1}, {1, 1, 1});  // faces outward as it comes: it is turned
    SolidMesh mesh = FillSurface(Joined(Box({0, 0, 0}, {3, 3, 3}), inner), options_);
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
  EXPECT_THAT(failure,
              ::testing::AnyOf(HasSubstr("intersect itself"), HasSubstr("intersects itself"),
                               HasSubstr("unusable"), HasSubstr("intersects itself")));
  if (GetParam() == Program::kTetgen) {
    EXPECT_THAT(failure, HasSubstr("intersect"));
  }
}

INSTANTIATE_TEST_SUITE_P(Programs, FillSurfaceTest,
                         ::testing::Values(Program::kTetgen, Program::kGmsh),
                         [](const auto& program) {
                           return program.param == Program::kTetgen ? "tetgen" : "gmsh";
                         });

// TetGen keeps the surface's nodes, so that places on it stay places.
TEST(FillSurfaceByTetgenTest, KeepsTheNodesOfTheSurface) {
  if (!FindProgram("tetgen")) GTEST_SKIP() << "needs the program tetgen";
  const SurfaceMesh sphere = Sphere(0.01);
  const SolidMesh mesh = FillSurface(sphere, {});
  ASSERT_GE(mesh.nodes.size(), sphere.nodes.size());
  for (std::size_t i = 0; i < sphere.nodes.size(); ++i) {
    EXPECT_LE((mesh.nodes[i] - sphere.nodes[i]).norm(), 1e-16) << i;
  }
}

TEST(FillSurfaceRefusalTest, RefusesWhatHasNoInside) {
  SurfaceMesh open = Box({0, 0, 0}, {1, 1, 1});
  open.triangles.pop_back();
  EXPECT_THAT(Failure(open, {}), HasSubstr("the surface is open at 3 edges"));
  EXPECT_THAT(Failure({}, {}), HasSubstr("no element"));
}

TEST(FillSurfaceRefusalTest, RefusesResolutionsThatAreNoneOrTooFine) {
  const SurfaceMesh box = Box({0, 0, 0}, {1, 1, 1});
  for (const double resolution : {-0.1, 1e-9, std::nan(""), HUGE_VAL}) {
    FillOptions options;
    options.resolution = resolution;
    // cbrt(6 sqrt(2) / 4e6).
    EXPECT_THAT(Failure(box, options), HasSubstr("expected 0, or at least 0.01285 m"));
  }
}

TEST(FillSurfaceRefusalTest, NamesThePackagesIfNoProgramIsThere) {
  const PathGuard nowhere("/nowhere");
  EXPECT_THAT(Failure(Box({0, 0, 0}, {1, 1, 1}), {}),
              HasSubstr("expected one of the packages tetgen and gmsh to be installed "
                        "(deploy/install.sh mesher)"));
}

// Programs that misbehave, in place of the real one.
class FakeMesherTest : public ::testing::Test {
 protected:
  std::string FailureOf(const std::string& script) {
    const auto file = folder_.Write("tetgen", "#!/bin/sh\n" + script);
    std::filesystem::permissions(file, std::filesystem::perms::owner_all);
    const PathGuard path((folder_ / "").string() + ":/bin:/usr/bin");
    FillOptions options;
    options.program = Program::kTetgen;
    options.timeout = std::chrono::milliseconds(2000);
    return Failure(Box({0, 0, 0}, {1, 1, 1}), options);
  }
  Scratch folder_;
};

TEST_F(FakeMesherTest, QuotesTheWordsOfOneThatFails) {
  EXPECT_THAT(FailureOf("echo out of   luck; exit 7\n"), HasSubstr("out of luck"));
}

TEST_F(FakeMesherTest, EndsOneThatNeverEnds) {
  EXPECT_THAT(FailureOf("sleep 100\n"), HasSubstr("took longer than 2000 ms and was stopped"));
}

TEST_F(FakeMesherTest, RefusesFilesThatAreDamagedOrAnotherVolume) {
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

// A shell round a bent void: the point lies in the void.
TEST(HolePointsTest, LieInsideEveryCavity) {
  SurfaceMesh s = Joined(Joined(Box({0, 0, 0}, {9, 9, 9}), Box({1, 1, 1}, {1, 7, 1})),
                         Joined(Box({4, 1, 1}, {4, 4, 4}), Box({5, 2, 2}, {2, 2, 2})));
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
