#include "slave/checks/chi_square.h"

#include <gtest/gtest.h>

namespace palpate {
namespace {

// Reference: printed tables of chi-square at 0.9999.
TEST(ChiSquareGateTest, IsTheQuantile) {
  const struct {
    int n;
    double quantile;
  } table[] = {{1, 15.137}, {2, 18.421}, {5, 25.745}, {10, 35.564}, {20, 52.386}};
  for (const auto& [n, quantile] : table) {
    EXPECT_GE(ChiSquareGate(n), quantile) << n;
    EXPECT_LT(ChiSquareGate(n), 1.08 * quantile) << n;
  }
}

}  // namespace
}  // namespace palpate
