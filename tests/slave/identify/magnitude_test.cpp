// Which numbers of a test no soft solid has.
#include "slave/identify/magnitude.h"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include "shared/text/text.h"
#include "tests/slave/identify/synthetic.h"

namespace palpate::identify {
namespace {

using testing::HasSubstr;

// A neo-Hookean material of this modulus in tension to a stretch.
std::string Complaint(double young_modulus, double stretch) {
  const HyperLaw law{.name = "", .terms = {{young_modulus / 3, 2}}};
  try {
    RequirePossible(CurveOf(law, TestKind::kUniaxial, stretch, 20));
  } catch (const InputError& e) {
    return e.what();
  }
  return {};
}

TEST(Magnitude, OfSoftSolidsIsAccepted) {
  for (const double young_modulus : {1.1e3, 1e5, 2.7e7})
    EXPECT_EQ(Complaint(young_modulus, 1.3), "");
  EXPECT_EQ(Complaint(1e5, 11), "");
  EXPECT_EQ(Complaint(1e5, 1.02), "");
}

// Each limit alone: the other numbers are those of a soft solid.
TEST(Magnitude, OfWrongUnitsIsRejectedWithTheOptionsThatGiveThem) {
  EXPECT_THAT(Complaint(0.9e3, 1.3), HasSubstr("Young's modulus [Pa] 900: accepted is 1e3 to 1e8"));
  EXPECT_THAT(Complaint(1.1e8, 1.05), HasSubstr("Young's modulus"));
  EXPECT_THAT(Complaint(9e7, 3), HasSubstr("largest stress"));
  EXPECT_THAT(Complaint(1e5, 1.005), HasSubstr("largest strain 0.005: accepted is 0.01"));
  EXPECT_THAT(Complaint(1e5, 13), HasSubstr("largest stretch 13: accepted is at most 12"));
  for (const char* option : {"header", "--stress-unit", "--height", "--diameter", "--area"}) {
    EXPECT_THAT(Complaint(31.6, 1.3), HasSubstr(option));
  }
}

TEST(Magnitude, OfRelaxationCountsThreeShearModuli) {
  RelaxationTable table{.name = "hold", .time = {0, 1, 2, 3}, .strain = {0, 0.1, 0.1, 0.1}};
  table.stress = {0, 50, 50, 50};
  EXPECT_THROW(RequirePossible(table), InputError);
  table.shear = true;
  EXPECT_NO_THROW(RequirePossible(table));
}

}  // namespace
}  // namespace palpate::identify
