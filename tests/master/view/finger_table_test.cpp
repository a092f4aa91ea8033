
#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include "master/view/console.h"
#include "tests/master/view/pinched_cube.h"

namespace palpate {
namespace {

using testing::ElementsAre;
using testing::IsEmpty;

TEST(FingerTableTest, TellsOfEachFingerAndOfTheObject) {
  ShapeMoment moment = PinchedCube(0.006);
  moment.fingers[1].contact.in_contact = false;
  moment.fingers[1].contact.force = Eigen::Vector3f(0, 0, 0);
  moment.fingers.push_back(moment.fingers[0]);
  moment.fingers[2].name = "a very long name";
  moment.fingers[2].contact.validity = Validity::kExtrapolated;
  moment.fingers.push_back(moment.fingers[0]);
  moment.fingers[3].contact.force.reset();
  moment.fingers[3].contact.validity = Validity::kTrackingLost;
  EXPECT_THAT(
      FingerTable(moment.fingers, moment.mesh.get()),
      ElementsAre("  ff       contact     0.423 N  (-0.42 +0 +0.05) N",
                  "  th       free            0 N  (+0 +0 +0) N",
                  "  a very l contact     0.423 N  (-0.42 +0 +0.05) N  extrapolated",
                  "  ff       force unknown (tracking lost)", "  object   moved by up to 6 mm"));
}

TEST(FingerTableTest, ALoneToolIsTheStatusLinesBusiness) {
  EXPECT_THAT(FingerTable({{"tool", FingerState()}}, nullptr), IsEmpty());
  EXPECT_EQ(FingerBrief({{"tool", FingerState()}}, nullptr), "");
  EXPECT_THAT(FingerTable({}, nullptr), IsEmpty());
}

TEST(FingerTableTest, SaysWhoTheFingertipsAre) {
  EXPECT_EQ(FingertipsInWords({}), "");
  EXPECT_EQ(FingertipsInWords({{"ff", "rnn_21", "polarity-free", {}}, {"th", "", "", {}}}),
            "fingertips ff (rnn_21; polarity-free), th (no neural network: its force is unknown)");
}

TEST(FingerTableTest, TheSameInOneLine) {
  ShapeMoment moment = PinchedCube(0.006);
  moment.fingers[1].contact.in_contact = false;
  EXPECT_EQ(FingerBrief(moment.fingers, moment.mesh.get()), "  ff 0.423 N  th free  moved 6 mm");
}

}  // namespace
}  // namespace palpate
