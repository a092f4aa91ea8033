#include <atomic>
#include <cstdint>
#include <stdexcept>

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include "master/view/shape_watch.h"
#include "tests/master/view/pinched_cube.h"
#include "tests/support/scratch.h"
#include "tests/support/vtu_text.h"

namespace palpate {
namespace {

using testing::HasSubstr;

class ShapeFileTest : public FolderTest {
 protected:
  [[nodiscard]] std::ptrdiff_t FilesThere() const {
    return std::distance(std::filesystem::directory_iterator(folder_), {});
  }

  const ShapeMoment moment_ = PinchedCube(0.006);
};

// Reference: the mesh itself: two points more, the fingers.
TEST_F(ShapeFileTest, AVtuHasTheDeformedSurfaceItsDisplacementAndTheFingersForces) {
  ASSERT_TRUE(WriteShape(moment_, folder_ / "a.vtu"));
  const std::string text = Read(folder_ / "a.vtu");
  const std::size_t nodes = moment_.mesh->positions.size();
  EXPECT_THAT(text, HasSubstr("NumberOfPoints=\"" + std::to_string(nodes + 2) + "\""));
  EXPECT_THAT(text, HasSubstr("\"displacement\""));
  EXPECT_THAT(text, HasSubstr("\"finger_force\""));
  EXPECT_THAT(text, testing::Not(HasSubstr("\"nodal_force\"")));
  const auto corners = VtuArray<std::int64_t>(text, "Name=\"connectivity\"");
  std::size_t at = 0;
  for (const auto& triangle : moment_.mesh->topology->surface.triangles) {
    for (const int corner : triangle) EXPECT_EQ(corners.at(at++), corner);
  }
  const auto xyz = VtuArray<double>(text, "type=\"Float64\"");
  ASSERT_EQ(xyz.size(), 3 * (nodes + 2));
  for (std::size_t i = 0; i < 3 * nodes; ++i) {
    EXPECT_EQ(xyz[i], moment_.mesh->positions[i / 3][static_cast<int>(i % 3)]);
  }
  RemoteMesh mesh = *moment_.mesh;
  mesh.nodal_forces.assign(nodes, {0, 0, 1});
  ShapeMoment moment = moment_;
  moment.mesh = std::make_shared<const RemoteMesh>(mesh);
  ASSERT_TRUE(WriteShape(moment, folder_ / "a.vtu"));
  EXPECT_THAT(Read(folder_ / "a.vtu"), HasSubstr("\"nodal_force\""));
  EXPECT_EQ(FilesThere(), 1) << "nothing half written is left";
}

TEST_F(ShapeFileTest, AFileThatCannotBeWrittenIsReported) {
  EXPECT_FALSE(WriteShape(moment_, "/nowhere/a.vtu"));
  ShapeFile file("/nowhere/a.vtu", [this] { return moment_.mesh; });
  EXPECT_THAT(file.Finish(), HasSubstr("/nowhere/a.vtu: cannot be written"));
}

// The hand presses and goes back: the last file shows the object at rest, the other one the
// press.
TEST_F(ShapeFileTest, TheDeepestMomentIsKeptForTheEnd) {
  std::mutex mutex;
  ShapeMoment now = PinchedCube(0.004);
  std::atomic<int> looked{0};
  ShapeFile file(folder_ / "a.vtu", [&] {
    const std::scoped_lock lock(mutex);
    ++looked;
    return now.mesh;
  });
  while (looked == 0) std::this_thread::sleep_for(std::chrono::milliseconds(1));
  {
    const std::scoped_lock lock(mutex);
    now = PinchedCube(0);
  }
  EXPECT_EQ(file.Finish(), "");
  const auto largest = [](const std::string& text) {
    double most = 0;
    for (const double u : VtuArray<double>(text, "Name=\"displacement\"")) {
      most = std::max(most, std::abs(u));
    }
    return most;
  };
  EXPECT_EQ(largest(Read(folder_ / "a.vtu")), 0);
  EXPECT_NEAR(largest(Read(DeepestFile(folder_ / "a.vtu"))), 0.004, 1e-4);
  EXPECT_EQ(DeepestFile("x/pinch.vtu"), "x/pinch-deepest.vtu");
}

}  // namespace
}  // namespace palpate
