#include "master/view/shape_picture.h"

#include <limits>
#include <sstream>
#include <vector>

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include "tests/master/view/pinched_cube.h"

namespace palpate {
namespace {

using testing::HasSubstr;
using testing::Not;
using testing::SizeIs;

// Lines of the picture that have `what` in them.
std::vector<std::string> LinesWith(const std::string& picture, const std::string& what) {
  std::vector<std::string> found;
  std::istringstream in(picture);
  for (std::string line; std::getline(in, line);) {
    if (line.find(what) != std::string::npos) found.push_back(line);
  }
  return found;
}

constexpr double kLegend = 700, kMiddle = 370;  // of the picture and of the object in it [px]

double Number(const std::string& line, const std::string& after) {
  return std::stod(line.substr(line.find(after) + after.size()));
}

TEST(ShapePictureTest, SaysWhatWhenAndHowMuch) {
  const std::string picture = DrawShape(PinchedCube(0.006));
  for (const char* words :
       {">foam-cube at 12.3 s<", ">moved by up to 6 mm<", ">ff<", ">0.423 N<", ">th<", ">0.401 N<",
        ">displacement [mm]<", ">0.6 N<", ">at rest<", ">20 mm<"}) {
    EXPECT_THAT(picture, HasSubstr(words));
  }
  EXPECT_THAT(picture, Not(HasSubstr("nan")));
}

// Both fingers press inwards: seen from the side, the left arrow runs to the right and the right
// one to the left, whichever way the pinch lies in the room.
TEST(ShapePictureTest, ThePinchIsSeenFromTheSide) {
  for (const double turn : {0.0, 0.7, 1.5708, 2.5, -1.0}) {
    const ShapeMoment moment = PinchedCube(0.006, turn);
    const std::string picture = DrawShape(moment);
    int to_the_right = 0, to_the_left = 0;
    for (const char* style : {"class=\"shaft\"", "class=\"through\""}) {
      for (const std::string& line : LinesWith(picture, style)) {
        const double from = Number(line, "x1=\""), to = Number(line, "x2=\"");
        if (from > kLegend) continue;
        const bool left_half = to < kMiddle;
        // A shaft that comes from behind is drawn twice, whole and shining through.
        if (left_half && to - from > 50) to_the_right = 1;
        if (!left_half && from - to > 50) to_the_left = 1;
      }
    }
    EXPECT_EQ(to_the_right + to_the_left, 2) << turn;
  }
}

TEST(ShapePictureTest, TheViewStandsStillWhileTheObjectMoves) {
  const auto rest = LinesWith(DrawShape(PinchedCube(0)), "class=\"rest\"");
  EXPECT_THAT(rest, SizeIs(9 * 6 + 1)) << "nine edges of six cells, and the legend's";
  EXPECT_EQ(LinesWith(DrawShape(PinchedCube(0.012)), "class=\"rest\""), rest);
}

TEST(ShapePictureTest, AFreeFingerIsARingAndAnUnknownForceIsSaid) {
  ShapeMoment moment = PinchedCube(0.006);
  moment.fingers[0].felt.in_contact = false;
  moment.fingers[1].felt.force.reset();
  moment.fingers[1].felt.validity = Validity::kStale;
  const std::string picture = DrawShape(moment);
  EXPECT_THAT(LinesWith(picture, "class=\"free\""), SizeIs(1));
  EXPECT_THAT(LinesWith(picture, "class=\"touch\""), SizeIs(1));
  EXPECT_THAT(LinesWith(picture, "class=\"shaft\""), SizeIs(1)) << "the legend's";
  EXPECT_THAT(picture, HasSubstr(">force unknown (stale)<"));
}

// Reference: at the middle of a face of six cells lies a node, which went `depth` inwards there.
TEST(ShapePictureTest, TheTouchedPlaceMovesWithTheSurface) {
  const ShapeMoment moment = PinchedCube(0.006);
  const Eigen::Vector3d place = PlaceNow(moment.fingers[0].felt, *moment.mesh);
  EXPECT_LT((place - Eigen::Vector3d(0.006, 0.03, 0.03)).norm(), 1e-6);
  FingerState free = moment.fingers[0].felt;
  free.in_contact = false;
  EXPECT_LT((PlaceNow(free, *moment.mesh) - Eigen::Vector3d(0, 0.03, 0.03)).norm(), 1e-6);
  FingerState far = moment.fingers[0].felt;
  far.p_S_contact = {5, 5, 5};
  EXPECT_LT((PlaceNow(far, *moment.mesh) - Eigen::Vector3d(5, 5, 5)).norm(), 1e-6);
  far.p_S_contact.setConstant(std::numeric_limits<float>::quiet_NaN());
  ShapeMoment odd = moment;
  odd.fingers[0].felt = far;
  EXPECT_THAT(DrawShape(odd), Not(HasSubstr("nan")));
}

TEST(ShapePictureTest, APlanarObjectIsSeenFromTheFrontAsItsOutline) {
  auto topology = std::make_shared<MeshTopology>();
  topology->surface.nodes = {{0, 0, 0}, {1, 0, 0}, {0, 1, 0}};
  topology->lines = {{0, 1}, {1, 2}, {2, 0}};
  RemoteMesh mesh;
  mesh.topology = topology;
  mesh.positions = {{0, 0, 0}, {1, 0, 0}, {0, 0.5, 0}};
  mesh.validity = Validity::kExtrapolated;
  ShapeMoment moment;
  moment.scene = "triangle";
  moment.mesh = std::make_shared<const RemoteMesh>(mesh);
  const std::string picture = DrawShape(moment);
  EXPECT_THAT(LinesWith(picture, "class=\"rest\""), SizeIs(3 + 1));
  EXPECT_THAT(picture, HasSubstr("moved by up to 500 mm (extrapolated)"));
}

TEST(ShapePictureTest, AnEmptyMeshIsAnEmptyPicture) {
  RemoteMesh mesh;
  mesh.topology = std::make_shared<MeshTopology>();
  ShapeMoment moment = PinchedCube(0);
  moment.mesh = std::make_shared<const RemoteMesh>(mesh);
  EXPECT_THAT(DrawShape(moment), Not(HasSubstr("nan")));
}

}  // namespace
}  // namespace palpate
