
#include <gtest/gtest.h>
#include <nlohmann/json.hpp>

#include "master/session/session.h"

namespace palpate {
namespace {

TEST(ReportTest, IsValidJsonForAnyNumbersAndTexts) {
  Report report;
  report.force_error = ForceError::Summary{std::nan(""), 0.14, 4120};
  report.force_peak = std::nan("");
  report.energy_min = -INFINITY;
  report.trouble = {"\xff\xfe broken \" words"};
  EXPECT_TRUE(nlohmann::json::accept(ToJson(report)));
}

}  // namespace
}  // namespace palpate
