#include <cmath>

#include <gtest/gtest.h>
#include <nlohmann/json.hpp>

#include "master/session/session.h"

namespace palpate {
namespace {

using nlohmann::json;

Report Example() {
  Report report;
  report.duration = 8;
  report.ticks = 7979;
  report.missed = 21;
  report.wake_us.Add(27);
  report.compute_us.Add(1.1);
  report.force_peak = 2.31;
  report.force_error = ForceError::Summary{0.06, 0.14, 4120};
  report.let_go_ticks = 12;
  report.state = OperatorState::kReady;
  report.render = "local";
  return report;
}

TEST(ReportTest, StaysJsonWhateverTheNumbersAndWords) {
  Report report = Example();
  report.force_peak = std::nan("");
  report.energy_min = -INFINITY;
  report.duration = 0;
  report.trouble = {"\xff\xfe broken \" words"};
  EXPECT_TRUE(json::accept(ToJson(report)));
}

}  // namespace
}  // namespace palpate
