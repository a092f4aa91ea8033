#include <cmath>
#include <fstream>
#include <stdexcept>

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

// Reference: the example in the contract, key by key.
TEST(ReportTest, HasEveryKeyOfTheContract) {
  const json report = json::parse(ToJson(Example()));
  for (const char* key :
       {"duration_s", "ticks", "missed", "rate_hz", "wake_us", "compute_us", "rtt_us", "states",
        "reconnects", "force_peak_N", "force_sent_peak_N", "force_error", "energy_min_J",
        "work_min_J", "clamped_ticks", "stale_ticks", "state", "render"}) {
    EXPECT_TRUE(report.contains(key)) << key;
  }
  EXPECT_EQ(report["rate_hz"], 997.375);
  for (const char* key : {"p50", "p99", "p999", "max"}) {
    EXPECT_TRUE(report["wake_us"][key].is_number()) << key;
    EXPECT_TRUE(report["compute_us"][key].is_number()) << key;
  }
  EXPECT_EQ(report["force_error"]["contact_ticks"], 4120);
  EXPECT_EQ(report["force_error"]["let_go_ticks"], 12);
  EXPECT_NEAR(report["force_error"]["relative_rms"].get<double>(), 0.06 / 2.31, 1e-6);
  EXPECT_EQ(report["state"], "READY");
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
