// `palpate-slave evaluate` as a user calls it, on clouds made from shapes that are known.
#include "slave/commands/evaluate/evaluate.h"

#include <filesystem>
#include <fstream>
#include <optional>
#include <set>
#include <sstream>
#include <variant>

#include <gmock/gmock.h>
#include <gtest/gtest.h>
#include <nlohmann/json.hpp>

#include "shared/mesh/solid_mesh.h"
#include "slave/mechanics/object_mesh.h"
#include "slave/mesh/files/mesh_file.h"
#include "slave/program/run_program.h"
#include "slave/scene/scene_loader.h"
#include "slave/study/clouds/pcd_file.h"
#include "slave/study/shape/virtual_depth_camera.h"
#include "tests/support/scratch.h"

namespace palpate {
namespace {

using testing::HasSubstr;
using testing::ThrowsMessage;
namespace fs = std::filesystem;

constexpr const char* kCamera = R"(
sense:
  depth_camera:
    pose: {translation: [30 mm, 30 mm, 500 mm], rotation: [180 deg, 0 deg, 0 deg]}
    noise: 1 mm
)";

class EvaluateTest : public FolderTest {
 protected:
  EvaluateTest() {
    options_.out = folder_ / "out";
    options_.scene = Scene(kCamera);
  }

  fs::path Scene(const std::string& sense) {
    return Write("scene.yaml", R"(
name: foam
object:
  geometry: {box: {size: [60 mm, 60 mm, 60 mm], cells: [6, 6, 6]}}
  material: {young_modulus: 3.8 kPa, poisson_ratio: 0.15}
  fixed: {plane: {axis: z, at: 0 mm}}
model: {kind: fem}
)" + sense);
  }
  // Returns the image of the object under `loads` from the scene's camera.
  fs::path Image(const fs::path& loads) {
    const auto scene = LoadScene(options_.scene, {}, SceneUse::kSolve);
    const auto shape = ShapeUnderTables(scene, {}, loads, nullptr);
    study::PointCloud cloud;
    const auto& camera = *scene.sense.depth_camera;
    for (const auto& p : study::ScanSurface(camera, shape.estimate_S, {}, 9)) {
      cloud.emplace_back().getVector3fMap() = (camera.X_SD.inverse() * p).cast<float>();
    }
    EXPECT_TRUE(study::WritePcd(folder_ / "cloud.pcd", cloud));
    return folder_ / "cloud.pcd";
  }
  nlohmann::json Run(int exit_code = 0) {
    testing::internal::CaptureStdout();
    testing::internal::CaptureStderr();
    EXPECT_EQ(RunEvaluate(options_, {}), exit_code);
    output_ = testing::internal::GetCapturedStdout();
    complained_ = testing::internal::GetCapturedStderr();
    std::ifstream stream(options_.out / "report.json");
    return nlohmann::json::parse(stream);
  }

  EvaluateOptions options_;
  std::string output_, complained_;
};

// A body without supports, pulled along z by 100 Pa at its ends; every triangle gets its share of
// the load.
class UniformTensionTest : public EvaluateTest {
 protected:
  static constexpr double kModulus = 2e5, kNu = 0.3, kPull = 100;  // [Pa], [-], [Pa]

  fs::path SceneOf(const std::string& geometry) {
    return Write("scene.yaml", "name: tension\nobject:\n  geometry: " + geometry +
                                   "\n  material: {young_modulus: 200 kPa, poisson_ratio: 0.3}\n"
                                   "model: {kind: fem, law: linear, residual: 1e-11}\n");
  }
  fs::path TensionOn(const SurfaceMesh& surface) {
    std::ostringstream rows;
    rows.precision(17);
    rows << "case,x,y,z,fx,fy,fz\n";
    for (const auto& [a, b, c] : surface.triangles) {
      const auto p = [&](int i) { return surface.nodes[static_cast<std::size_t>(i)]; };
      const Eigen::Vector3d at = (p(a) + p(b) + p(c)) / 3;
      const double share = (p(b) - p(a)).cross(p(c) - p(a)).z() / 2;  // [m^2]
      if (share == 0) continue;
      rows << "pull," << at.x() << ',' << at.y() << ',' << at.z() << ",0,0," << kPull * share
           << '\n';
    }
    return Write("loads.csv", rows.str());
  }
  // Reference: u = p / E (-nu x, -nu y, z) plus an arbitrary rigid motion. The elements represent
  // linear displacements exactly, so only the solver's residual remains.
  void ExpectClosedForm(const fs::path& file) {
    const auto scene = LoadScene(file, {}, SceneUse::kSolve);
    const ObjectMesh mesh = MeshObject(scene, std::nullopt);
    const SurfaceMesh surface = SurfaceOf(mesh);
    const auto shape = ShapeUnderTables(scene, {}, TensionOn(surface), nullptr);
    std::set<int> nodes;
    for (const auto& triangle : surface.triangles) nodes.insert(triangle.begin(), triangle.end());
    const auto rows = static_cast<Eigen::Index>(3 * nodes.size());
    Eigen::MatrixXd rigid(rows, 6);
    Eigen::VectorXd rest(rows);
    Eigen::Index row = 0;
    for (const int node : nodes) {
      const auto i = static_cast<std::size_t>(node);
      const Eigen::Vector3d& p = surface.nodes[i];
      const Eigen::Vector3d u = shape.estimate_S.nodes[i] - shape.rest_S.nodes[i];
      rest.segment<3>(row) =
          u - kPull / kModulus * Eigen::Vector3d(-kNu * p.x(), -kNu * p.y(), p.z());
      rigid.block<3, 3>(row, 0).setIdentity();
      rigid.block<3, 3>(row, 3) << 0, p.z(), -p.y(), -p.z(), 0, p.x(), p.y(), -p.x(), 0;
      row += 3;
    }
    rest -= rigid * rigid.colPivHouseholderQr().solve(rest);
    const double largest = kPull / kModulus * Diagonal(surface.nodes) / 2;
    EXPECT_LT(rest.lpNorm<Eigen::Infinity>(), 1e-9 * largest);
  }
};

// As many triangles as nodes, 900.
TEST_F(UniformTensionTest, OfABoxOfAsManyTrianglesAsNodesMovesTheNodes) {
  ExpectClosedForm(SceneOf("{box: {size: [80 mm, 90 mm, 90 mm], cells: [8, 9, 9]}}"));
}

// Closed surfaces have nearly twice as many triangles as nodes. A mesher fills them.
TEST_F(UniformTensionTest, OfAClosedSurfaceMovesTheNodes) {
  if (!FindProgram("tetgen") && !FindProgram("gmsh")) GTEST_SKIP() << "no mesher is installed";
  SurfaceMesh ball{
      {{1, 0, 0}, {-1, 0, 0}, {0, 1, 0}, {0, -1, 0}, {0, 0, 1}, {0, 0, -1}},
      {{0, 2, 4}, {2, 1, 4}, {1, 3, 4}, {3, 0, 4}, {2, 0, 5}, {1, 2, 5}, {3, 1, 5}, {0, 3, 5}}};
  for (int i = 0; i < 3; ++i) ball = Refined(ball);
  for (auto& p : ball.nodes) p = 0.03 * p.normalized();
  ASSERT_TRUE(WriteGmsh(folder_ / "ball.msh", ball));
  ExpectClosedForm(SceneOf("{mesh: ball.msh, unit: m}"));
}

// Two images of one surface differ by their noise: 1 mm in leaves of 10 mm.
TEST_F(EvaluateTest, ShapeUnderTheRightLoadsScoresHighAndTheOneAtRestDoesNot) {
  // Pulled up by 1 N over a patch: the top bulges by more than a leaf.
  const auto loads = Write("loads.csv", "case,x,y,z,fx,fy,fz,width\na,0.03,0.03,0.06,0,0,2,0.03\n");
  options_.cloud = Image(loads);
  options_.segment = "no";
  options_.loads = loads;
  const auto right = Run();
  EXPECT_THAT(output_, HasSubstr("octree score"));
  EXPECT_GT(right["score"]["octree"], 0.98);
  EXPECT_LT(right["score"]["measured_to_surface_m"]["rms"], 0.0015);
  options_.loads.clear();
  const auto wrong = Run();
  EXPECT_EQ(wrong["state"], "at rest");
  EXPECT_LT(wrong["score"]["octree"], right["score"]["octree"].get<double>() - 0.1);
  EXPECT_GT(wrong["score"]["measured_to_surface_m"]["max"], 0.01);
}

TEST_F(EvaluateTest, CloudWithoutARegionFailsAndSaysWhy) {
  options_.cloud = Write("few.pcd",
                         "VERSION 0.7\nFIELDS x y z\nSIZE 4 4 4\nTYPE F F F\nCOUNT 1 1 1\nWIDTH 2\n"
                         "HEIGHT 1\nPOINTS 2\nDATA ascii\n0 0 0.4\n0 0.1 0.4\n");
  const auto report = Run(1);
  EXPECT_THAT(complained_, HasSubstr("few.pcd: no score: the cloud has no region"));
  EXPECT_EQ(report["object"]["points"], 0);
  EXPECT_TRUE(report["score"]["octree"].is_null());
}

TEST_F(EvaluateTest, UnusableArgumentsSayWhatIsAccepted) {
  options_.cloud = Image({});
  const EvaluateOptions usable = options_;
  const auto refuses = [&](const auto& change, const char* words) {
    EvaluateOptions options = usable;
    change(&options);
    EXPECT_THAT([&] { RunEvaluate(options, {}); }, ThrowsMessage<std::exception>(HasSubstr(words)));
  };
  using O = EvaluateOptions*;
  refuses([](O o) { o->segment = "magic"; }, "expected surfaces, colour or no");
  refuses([](O o) { o->leaf = 0; }, "--leaf");
  refuses([](O o) { o->at = std::vector{0.0, 0.0, HUGE_VAL}; }, "--at");
  refuses(
      [](O o) {
        o->at = std::vector{0.0, 0.3, 0.44};
      },
      "--at 0,0.3,0.44: the nearest point of an object is 0.2");
  refuses([&](O o) { o->cloud = folder_ / "no.pcd"; }, "no.pcd: there is no such file");
  const auto outside = Write("outside.csv", "case,x,y,z,fx,fy,fz\na,0.03,0.03,0.5,0,0,1\n");
  refuses([&](O o) { o->loads = outside; }, "outside.csv:2");
  const auto flat = Write(
      "flat.yaml",
      "name: flat\nobject:\n  geometry: {rectangle: {width: 1 m, height: 1 m, "
      "thickness: 1 mm}}\n  material: {young_modulus: 1 kPa, poisson_ratio: 0.3}\nmodel: {}\n");
  refuses([&](O o) { o->scene = flat; }, "evaluate expects a volume");
}

}  // namespace
}  // namespace palpate
