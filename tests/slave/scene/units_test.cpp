#include "slave/scene/units.h"

#include <numbers>
#include <tuple>

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include "tests/slave/scene/decimal_comma.h"

namespace palpate {
namespace {

using enum Dimension;

// Reference: deploy/scenes/README.md, and the definitions of the prefixes. Exact: one division or
// product, so `127 kPa` and `127000` are the same number.
TEST(UnitsTest, EveryUnitIsItsDefinition) {
  const std::tuple<const char*, Dimension, double> kRows[] = {
      {"0.35 m", kLength, 0.35},
      {"0.35 mm", kLength, 0.35 / 1e3},
      {"5.87um", kLength, 5.87 / 1e6},
      {"3 nm", kLength, 3 / 1e9},
      {"2 km", kLength, 2000},
      {"127 Pa", kPressure, 127},
      {"127 kPa", kPressure, 127000},
      {"1.51 MPa", kPressure, 1.51e6},
      {"2 GPa", kPressure, 2e9},
      {"1 TPa", kPressure, 1e12},
      {"3.3 N", kForce, 3.3},
      {"3.3 mN", kForce, 3.3 / 1e3},
      {"3.3 uN", kForce, 3.3 / 1e6},
      {"2 s", kTime, 2},
      {"20 ms", kTime, 20 / 1e3},
      {"7 us", kTime, 7 / 1e6},
      {"60 Hz", kFrequency, 60},
      {"1 kHz", kFrequency, 1000},
      {"180 deg", kAngle, std::numbers::pi},
      {"1.5 rad", kAngle, 1.5},
      {"1050 kg/m3", kDensity, 1050},
      {"1.05 g/cm3", kDensity, 1050},
      {"20 mm/s", kSpeed, 20 / 1e3},
      {"64 px", kPixels, 64},
      {"12 N/m", kTension, 12},
      {"12 mN/m", kTension, 12 / 1e3},
      {"1.5 N/mm", kTension, 1500},
      {"5 %", kNumber, 5 / 1e2},
  };
  for (const auto& [text, dimension, expected] : kRows) {
    const auto value = ParseQuantity(text, dimension);
    ASSERT_TRUE(value.has_value()) << text;
    EXPECT_DOUBLE_EQ(*value, expected) << text;
  }
}

TEST(UnitsTest, WhatIsNoQuantityIsRefused) {
  for (const char* text : {"",     " ",      "mm",  "5 kg", "5 kPa",   "5 mm mm", "5 m m",
                           "5 MM", "1,5 mm", "nan", "inf",  "-inf",    "1e400",   "1e308 km",
                           "0x10", "5-",     "--5", "+-5",  "five mm", "5%",      "5 deg"}) {
    EXPECT_EQ(ParseQuantity(text, kLength), std::nullopt) << text;
  }
}

}  // namespace
}  // namespace palpate
