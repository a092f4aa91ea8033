// Runs the table of promises: each row on the slave of `serve`, on the clock of its devices.
#include <algorithm>
#include <fstream>
#include <functional>
#include <sstream>

#include <gtest/gtest.h>

#include "shared/state/driven_clock.h"
#include "slave/scene/scene_loader.h"
#include "tests/promises/devices.h"
#include "tests/support/paths.h"

namespace palpate::promises {
namespace {

std::string CheckOf(const SlaveState& state) {
  return state.check == FailedCheck::kNone ? "none" : std::string(ToString(state.check));
}

std::string NameOf(Phase phase) {
  switch (phase) {
    case Phase::kFollowing:
      return "FOLLOWING";
    case Phase::kHold:
      return "HOLD";
    case Phase::kEstop:
      return "ESTOP";
    default:
      return "another";
  }
}

// The line of a page with the sentence; 0: none.
int LineOf(const std::filesystem::path& page, const std::string& sentence) {
  std::ifstream stream(SourcePath("/" + page.string()));
  std::string line;
  for (int number = 1; std::getline(stream, line); ++number) {
    if (line.find(sentence) != std::string::npos) return number;
  }
  return 0;
}

class PromiseTest : public testing::TestWithParam<Row> {
 protected:
  void Run(const Row& row) {
    const std::string file = SourcePath("/" + row.scene.string());
    const Scene devices = LoadScene(file, row.site);
    std::vector<std::string> overrides = row.site;
    overrides.insert(overrides.end(), row.stated.begin(), row.stated.end());
    const Scene scene = LoadScene(file, overrides);
    const Samples& samples = SamplesOf(devices);
    const DrivenClock clock;
    const auto slave = MakeLiveSlave(scene);
    Devices hands(scene, *slave);
    auto next = row.events.begin();
    double t = 0;
    for (const v1::SimulatedSample& sample : samples) {
      while (next != row.events.end() && next->at <= t + 1e-9) hands.Begin(*next++);
      seen_.push_back(hands.Send(sample));
      t = seen_.back().t + 1 / SensorRate(scene.sense);
      const v1::Vec3& f = sample.truth().force();
      peak_ = std::max(peak_, Eigen::Vector3d(f.x(), f.y(), f.z()).norm());
    }
    EXPECT_TRUE(next == row.events.end()) << "an event after the last sample, " << t << " s";
  }

  void Compare(const Expectation& expected) const {
    std::vector<const Seen*> within;
    for (const Seen& one : seen_) {
      if (one.t >= expected.from && one.t <= expected.to) within.push_back(&one);
    }
    ASSERT_FALSE(within.empty());
    const auto is_shared = [&](const char* what, const std::string& wanted,
                               const std::function<std::string(const SlaveState&)>& read) {
      std::map<std::string, int> counts;
      for (const Seen* one : within) ++counts[read(one->state)];
      std::ostringstream all;
      for (const auto& [name, count] : counts) all << ' ' << name << ' ' << count;
      EXPECT_GE(counts[wanted], expected.share * static_cast<double>(within.size()))
          << what << ' ' << wanted << ", seen:" << all.str();
    };
    if (expected.check) is_shared("check", *expected.check, CheckOf);
    if (expected.validity) {
      is_shared("validity", *expected.validity,
                [](const SlaveState& s) { return std::string(ToString(s.validity)); });
    }
    if (expected.force) {
      is_shared("force", *expected.force ? "known" : "unknown", [](const SlaveState& s) {
        return std::string(IsForceKnown(s) ? "known" : "unknown");
      });
    }
    if (expected.phase) {
      is_shared("phase", *expected.phase, [](const SlaveState& s) { return NameOf(s.phase); });
    }
    for (const Seen* one : within) CompareOne(expected, *one);
    const std::vector<std::string>& alarms = within.back()->alarms;
    if (expected.alarms)
      EXPECT_EQ(!alarms.empty(), *expected.alarms) << (alarms.empty() ? "" : alarms[0]);
    if (!expected.alarm) return;
    const auto has = [&](const std::string& alarm) {
      return alarm.find(*expected.alarm) != std::string::npos;
    };
    EXPECT_TRUE(std::ranges::any_of(alarms, has)) << *expected.alarm;
  }

  void CompareOne(const Expectation& expected, const Seen& seen) const {
    const SlaveState& state = seen.state;
    const auto vector = [](const v1::Vec3& v) { return Eigen::Vector3d(v.x(), v.y(), v.z()); };
    if (expected.never) EXPECT_NE(CheckOf(state), *expected.never) << seen.t << " s";
    if (expected.force_error && state.validity == Validity::kValid && state.force) {
      EXPECT_LE((*state.force - vector(seen.truth.force())).norm(), *expected.force_error * peak_)
          << seen.t << " s";
    }
    if (expected.tip_error_m && state.validity != Validity::kTrackingLost) {
      EXPECT_LE((state.p_S_tip - vector(seen.truth.p_s_tip())).norm(), *expected.tip_error_m)
          << seen.t << " s";
    }
    if (expected.sigma && IsForceKnown(state)) {
      EXPECT_GE(state.sigma, (*expected.sigma)[0]) << seen.t << " s";
      EXPECT_LE(state.sigma, (*expected.sigma)[1]) << seen.t << " s";
    }
  }

  std::vector<Seen> seen_;
  double peak_ = 0;  // of the true force [N]
};

TEST_P(PromiseTest, IsKept) {
  const Row& row = GetParam();
  const int line = LineOf(row.page, row.promise);
  ASSERT_GT(line, 0) << row.page << " does not promise: " << row.promise;
  ASSERT_NO_THROW(Run(row));
  for (const Expectation& expected : row.expected) {
    SCOPED_TRACE(testing::Message() << row.page.string() << ':' << line << ": " << row.promise
                                    << "; from " << expected.from << " s");
    Compare(expected);
  }
}

INSTANTIATE_TEST_SUITE_P(Table, PromiseTest,
                         testing::ValuesIn(ReadRows(SourcePath("/tests/promises/promises.yaml"))),
                         [](const auto& row) { return row.param.name; });

}  // namespace
}  // namespace palpate::promises
