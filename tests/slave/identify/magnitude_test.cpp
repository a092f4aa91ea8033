// Tests the limits beyond which the numbers of a material test cannot be those of a soft solid.
#include "slave/identify/magnitude.h"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include "shared/text/text.h"
#include "tests/slave/identify/synthetic.h"

namespace palpate::identify {
namespace {

using testing::HasSubstr;

// The message on a neo-Hookean material of this modulus in tension to a stretch: a remark, or why
// it is refused.
std::string MagnitudeComplaint(double young_modulus, double stretch, bool units_named = true) {
  const HyperLaw law{.name = "", .terms = {{young_modulus / 3, 2}}};
  MaterialTest test = CurveOf(law, TestKind::kUniaxial, stretch, 20);
  test.units_named = units_named;
  try {
    return RequirePossible(test);
  } catch (const InputError& e) {
    return e.what();
  }
}

TEST(Magnitude, OfSoftSolidsIsAcceptedWhateverNamesTheUnit) {
  for (const bool named : {false, true}) {
    for (const double young_modulus : {3.1e3, 1e5, 9e6})
      EXPECT_EQ(MagnitudeComplaint(young_modulus, 1.3, named), "");
    EXPECT_EQ(MagnitudeComplaint(1e5, 11, named), "");
    EXPECT_EQ(MagnitudeComplaint(1e5, 1.02, named), "");
  }
}

// Brain is of 882 Pa, steel of 200 GPa; silicones break at a stretch of 18.
TEST(Magnitude, OfRareSolidsIsAcceptedWithARemarkWhereTheUnitIsNamed) {
  EXPECT_THAT(MagnitudeComplaint(882, 1.1), HasSubstr("a modulus of 882 Pa is rare"));
  EXPECT_THAT(MagnitudeComplaint(11, 1.3), HasSubstr("is rare"));
  for (const double mistaken : {2e6 / 1e3, 3.4e5 / 1e3, 1.2e4 * 1e3}) {
    EXPECT_THAT(MagnitudeComplaint(mistaken, 1.3),
                HasSubstr("is rare for a soft solid: check the unit"));
  }
  EXPECT_THAT(MagnitudeComplaint(2e11, 1.001), HasSubstr("a modulus of 2e+11 Pa is rare"));
  EXPECT_THAT(MagnitudeComplaint(9e11, 1.001), HasSubstr("is rare"));
  EXPECT_THAT(MagnitudeComplaint(6e4, 18), HasSubstr("a stretch of 18 is rare"));
  for (const double young_modulus : {882.0, 2e8}) {
    EXPECT_THAT(MagnitudeComplaint(young_modulus, 1.03, false),
                HasSubstr("a column that names no unit"));
  }
}

// Tests each limit alone, with plausible other numbers.
TEST(Magnitude, OfWrongUnitsIsRejectedWithTheOptionsThatGiveThem) {
  EXPECT_THAT(MagnitudeComplaint(9, 1.3), HasSubstr("Young's modulus [Pa] 9: expected 10 to 1e12"));
  EXPECT_THAT(MagnitudeComplaint(1.1e12, 1.001), HasSubstr("Young's modulus"));
  EXPECT_THAT(MagnitudeComplaint(9e7, 3), HasSubstr("largest stress"));
  EXPECT_THAT(MagnitudeComplaint(1e5, 1.005), HasSubstr("largest strain 0.005: expected 0.01"));
  EXPECT_THAT(MagnitudeComplaint(2e9, 1.3), HasSubstr("largest strain 0.3: expected at most 0.05"));
  for (const char* option : {"header", "--stress-unit", "--height", "--diameter", "--area"}) {
    EXPECT_THAT(MagnitudeComplaint(3, 1.3), HasSubstr(option));
  }
}

TEST(Magnitude, OfRelaxationCountsThreeShearModuli) {
  RelaxationTable table{.name = "hold", .time = {0, 1, 2, 3}, .strain = {0, 0.1, 0.1, 0.1}};
  table.stress = {0, 50, 50, 50};
  table.units_named = false;
  EXPECT_THROW(RequirePossible(table), InputError);
  table.shear = true;
  EXPECT_NO_THROW(RequirePossible(table));
}

}  // namespace
}  // namespace palpate::identify
