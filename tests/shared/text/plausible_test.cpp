#include "shared/text/plausible.h"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

namespace palpate {
namespace {

using testing::AllOf;
using testing::HasSubstr;
using testing::Optional;

// References: water 1000, PU foam 30 and steel 7850 kg/m^3; gravity 9.81 m/s^2.
TEST(PlausibleTest, CommonValuesDrawNoRemark) {
  for (const double density : {30.0, 1000.0, 7850.0}) {
    EXPECT_EQ(ImplausibleRemark("density", density, Plausible::kDensity), std::nullopt);
  }
  for (const double modulus : {300.0, 3.8e3, 2e6, 3e9}) {
    EXPECT_EQ(ImplausibleRemark("E", modulus, Plausible::kYoungModulus), std::nullopt);
  }
  EXPECT_EQ(ImplausibleRemark("gravity", 9.81, Plausible::kGravity), std::nullopt);
  EXPECT_EQ(ImplausibleRemark("force", 40, Plausible::kFingertipForce), std::nullopt);
}

TEST(PlausibleTest, ARemarkHasKeyValueAndTheValueInTheLikelyUnit) {
  EXPECT_THAT(ImplausibleRemark("object.material.density", 1.07, Plausible::kDensity),
              Optional(AllOf(HasSubstr("object.material.density = 1.07 kg/m3"),
                             HasSubstr("in g/cm3 it would be 1070 kg/m3"))));
  EXPECT_THAT(ImplausibleRemark("density", 1.07e-9, Plausible::kDensity),
              Optional(HasSubstr("in t/mm3 it would be 1070 kg/m3")));
  EXPECT_THAT(ImplausibleRemark("gravity", 9810, Plausible::kGravity),
              Optional(HasSubstr("in mm/s2 it would be 9.81 m/s2")));
  EXPECT_THAT(ImplausibleRemark("gravity", 1, Plausible::kGravity),
              Optional(HasSubstr("in g it would be 9.807 m/s2")));
  EXPECT_THAT(ImplausibleRemark("E", 20, Plausible::kYoungModulus),
              Optional(HasSubstr("in kPa it would be 2e+04 Pa")));
  EXPECT_THAT(ImplausibleRemark("force", 2301, Plausible::kFingertipForce),
              Optional(HasSubstr("in mN it would be 2.301 N")));
  EXPECT_THAT(ImplausibleRemark("size", 60, Plausible::kBodySize),
              Optional(HasSubstr("in mm it would be 0.06 m")));
}

}  // namespace
}  // namespace palpate
