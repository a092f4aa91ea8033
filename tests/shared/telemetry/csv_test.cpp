#include "shared/telemetry/csv.h"

#include <clocale>
#include <cmath>
#include <string>

#include <gtest/gtest.h>

namespace palpate {
namespace {

std::string Written(double value, int digits) {
  std::string text;
  AppendNumber(&text, value, digits);
  return text;
}

TEST(AppendNumberTest, SeventeenDigitsRoundTrip) {
  for (const double value : {0.1, -1.0 / 3, 1e-300, 1.7976931348623157e308}) {
    EXPECT_EQ(std::stod(Written(value, 17)), value);
  }
}

TEST(AppendNumberTest, UnknownNumbersAreEmptyAndZeroHasNoSign) {
  EXPECT_EQ(Written(std::nan(""), 7), "");
  EXPECT_EQ(Written(INFINITY, 7), "");
  EXPECT_EQ(Written(-0.0, 7), "0");
  EXPECT_EQ(Written(0.25, 7), "0.25");
}

TEST(AppendNumberTest, TheLocaleDoesNotMatter) {
  const std::string before = std::setlocale(LC_NUMERIC, nullptr);
  if (std::setlocale(LC_NUMERIC, "de_DE.UTF-8") == nullptr) GTEST_SKIP() << "no German locale";
  EXPECT_EQ(Written(0.25, 7), "0.25");
  std::setlocale(LC_NUMERIC, before.c_str());
}

}  // namespace
}  // namespace palpate
