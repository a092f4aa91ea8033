#include "slave/mechanics/plate/contacts.h"

#include <limits>

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include "tests/slave/mechanics/plate/presses.h"

namespace palpate::plate {
namespace {

using plates::Loaded;
using plates::Moved;
using testing::HasSubstr;

constexpr double kNaN = std::numeric_limits<double>::quiet_NaN();
const Geometry kPlate{.radius = 0.039, .thickness = 0.001};

std::string_view Why(std::vector<Contact> contacts) {
  std::vector<Touch> touches;
  return Check(contacts, kPlate, &touches);
}

TEST(PlateContacts, TheImpossibleIsRefusedWithItsReason) {
  EXPECT_THAT(Why({Moved({kNaN, 0}, 1e-3)}), HasSubstr("finite"));
  EXPECT_THAT(Why({Moved({0, 0}, kNaN)}), HasSubstr("finite"));
  EXPECT_THAT(Why({Moved({0, 0}, 1e-3, kNaN)}), HasSubstr("finite"));
  EXPECT_THAT(Why({Moved({0, 0}, 1e-3, -1)}), HasSubstr("negative"));
  EXPECT_THAT(Why({Moved({0, 0}, 1e300)}), HasSubstr("too large"));
  EXPECT_THAT(Why({Moved({0.04, 0}, 1e-3)}), HasSubstr("beyond the rim"));
  EXPECT_THAT(Why({Moved({1e300, 0}, 1e-3)}), HasSubstr("beyond the rim"));
  EXPECT_THAT(Why({Loaded({0.035, 0}, 1, 0.01)}), HasSubstr("over the rim"));
  EXPECT_THAT(Why({Moved({0.039, 0}, 1e-3)}), HasSubstr("clamped rim"));
  Contact across = Loaded({0, 0}, 1);
  across.prescribed_O.x() = 1;
  EXPECT_THAT(Why({across}), HasSubstr("normal"));
  Contact above = Loaded({0, 0}, 1);
  above.p_O.z() = 6e-4;
  EXPECT_THAT(Why({above}), HasSubstr("off the plate"));
  above.p_O.z() = -5e-4;  // the lower face
  EXPECT_EQ(Why({above}), "");
}

TEST(PlateContacts, LoadsOverlapButMovedPatchesDoNot) {
  EXPECT_EQ(Why({Loaded({0, 0}, 1), Loaded({0, 0}, 1)}), "");
  EXPECT_EQ(Why({Loaded({0, 0}, 1, 0.01), Loaded({0.004, 0}, 1, 0.01)}), "");
  EXPECT_THAT(Why({Moved({0, 0}, 1e-3), Moved({0, 0}, 1e-3)}), HasSubstr("overlaps"));
  EXPECT_THAT(Why({Moved({0, 0}, 1e-3, 0.01), Loaded({0.004, 0}, 1, 0.01)}), HasSubstr("overlaps"));
  EXPECT_EQ(Why({Moved({0, 0}, 1e-3, 0.01), Loaded({0.01, 0}, 1, 0.01)}), "");  // they touch
}

}  // namespace
}  // namespace palpate::plate
