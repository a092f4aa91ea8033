#include <limits>

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include "shared/metrics/metrics_page.h"

namespace palpate {
namespace {

// Source: Prometheus text-based exposition format 0.0.4, its own example's shape.
TEST(MetricTest, IsWrittenAsThePagesThatReadItExpect) {
  const Metrics metrics{Counter("palpate_ticks_total", "Ticks.", 1027),
                        {"palpate_phase",
                         "What it does.",
                         Metric::Type::kGauge,
                         {{Label("phase", "ready"), 1}, {Label("phase", "hold"), 0}}}};
  EXPECT_EQ(ToText(metrics),
            "# HELP palpate_ticks_total Ticks.\n"
            "# TYPE palpate_ticks_total counter\n"
            "palpate_ticks_total 1027\n"
            "# HELP palpate_phase What it does.\n"
            "# TYPE palpate_phase gauge\n"
            "palpate_phase{phase=\"ready\"} 1\n"
            "palpate_phase{phase=\"hold\"} 0\n");
}

TEST(MetricTest, ASceneNameCannotBreakTheFormat) {
  EXPECT_EQ(Label("scene", "a\"b\\c\nd"), "scene=\"a\\\"b\\\\c d\"");
}

}  // namespace
}  // namespace palpate
