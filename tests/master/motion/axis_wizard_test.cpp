#include "master/motion/axis_wizard.h"

#include <string>
#include <vector>

#include <gmock/gmock.h>
#include <gtest/gtest.h>

namespace palpate {
namespace {

using Eigen::Vector3d;
using testing::ElementsAre;
using testing::HasSubstr;

// An operator at a device, at 100 readings per second.
class Operator {
 public:
  void MoveBy(const Vector3d& way) {
    for (int i = 0; i < 50; ++i) Say(p_ += way / 50);
  }
  void Rest(double seconds = 0.7) {
    for (int i = 0; i < seconds * 100; ++i) Say(p_);
  }
  AxisWizard wizard;
  std::vector<std::string> said;

 private:
  void Say(const Vector3d& p_D) {
    const std::string sentence = wizard.Add(p_D, t_ += 0.01);
    if (!sentence.empty()) said.push_back(sentence);
  }
  Vector3d p_{0.1, -0.2, 0.3};
  double t_ = 5;
};

// Reference: the map itself. A device whose axes are known is moved along right, up and forward of
// M, with a tenth of the motion along the other axes.
TEST(AxisWizardTest, FindsEverySignedPermutation) {
  for (const char* order : {"xyz", "xzy", "yxz", "yzx", "zxy", "zyx"}) {
    for (int signs = 0; signs < 8; ++signs) {
      std::string text;
      for (int i = 0; i < 3; ++i) {
        text += std::string(i > 0 ? "," : "") + ((signs >> i & 1) != 0 ? "-" : "") + order[i];
      }
      const AxisMap device = AxisMap::Parse(text);
      Operator someone;
      for (const Vector3d& way_M : {Vector3d(0.05, 0.005, -0.005), Vector3d(0.005, 0.05, 0.005),
                                    Vector3d(-0.005, 0.005, -0.05)}) {
        someone.Rest();
        someone.MoveBy(device.ToDevice(way_M));
      }
      ASSERT_TRUE(someone.wizard.axes()) << text;
      EXPECT_EQ(ToString(*someone.wizard.axes()), text);
    }
  }
}

TEST(AxisWizardTest, AsksAgainWhereAMotionIsNotClear) {
  Operator someone;
  someone.Rest();
  someone.MoveBy({0.04, 0.03, 0});
  EXPECT_THAT(someone.said.back(), HasSubstr("along no single axis"));
  someone.Rest();
  someone.MoveBy({0.04, 0, 0});
  someone.Rest();
  someone.MoveBy({-0.04, 0, 0});
  EXPECT_THAT(someone.said.back(), HasSubstr("the axis of an earlier motion"));
  someone.Rest();
  someone.MoveBy({0, 0, 0.04});
  someone.Rest();
  someone.MoveBy({0, 0.04, 0});
  ASSERT_TRUE(someone.wizard.axes());
  EXPECT_EQ(ToString(*someone.wizard.axes()), "x,z,-y");
  EXPECT_TRUE(someone.wizard.axes()->P().determinant() > 0);
}

TEST(AxisWizardTest, TheEndOfOneMotionIsNotTheNext) {
  Operator someone;
  someone.Rest();
  someone.MoveBy({0.2, 0, 0});
  someone.MoveBy({0, 0.1, 0});  // without a rest in between
  someone.Rest();
  EXPECT_THAT(someone.said, ElementsAre("Hold the device still.", "Move the device to the right.",
                                        "Good. Hold the device still.", "Move the device up."));
}

}  // namespace
}  // namespace palpate
