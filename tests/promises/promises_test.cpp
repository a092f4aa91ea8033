// Runs the table of promises: each row on the slave of `serve`, on the clock of its devices.
#include <algorithm>
#include <cmath>
#include <fstream>
#include <functional>
#include <map>
#include <regex>
#include <set>
#include <sstream>

#include <gtest/gtest.h>

#include "shared/state/driven_clock.h"
#include "shared/wire/enum_names.h"
#include "slave/scene/scene_loader.h"
#include "tests/promises/devices.h"
#include "tests/support/paths.h"

namespace palpate::promises {

// Names a row that fails.
static void PrintTo(const Row& row, std::ostream* out) {
  *out << row.page.string() << ": " << row.promise;
}

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

const std::map<std::string, Event> kEvents{{"contact", Event::kContact},
                                           {"release", Event::kRelease},
                                           {"puncture", Event::kPuncture},
                                           {"tracking_lost", Event::kTrackingLost},
                                           {"tracking_regained", Event::kTrackingRegained},
                                           {"limit", Event::kLimit},
                                           {"hold", Event::kHold},
                                           {"command_refused", Event::kCommandRefused}};

// The line of a page with the sentence; 0: none.
int LineOf(const std::filesystem::path& page, const std::string& sentence) {
  std::ifstream stream(SourcePath("/" + page.string()));
  std::string line;
  for (int number = 1; std::getline(stream, line); ++number) {
    if (line.find(sentence) != std::string::npos) return number;
  }
  return 0;
}

// A valid force whose error exceeds both limits is an undetected error, as in the robustness
// campaign.
constexpr double kSilentShare = 0.05;  // of the largest true force
constexpr double kSilentSigmas = 3;
constexpr double kContactShare = 0.01;  // of the largest true force

class PromiseTest : public testing::TestWithParam<Row> {
 protected:
  void Run(const Row& row) {
    const std::string file = SourcePath("/" + row.scene.string());
    const Scene devices = LoadScene(file, row.site);
    std::vector<std::string> overrides = row.site;
    overrides.insert(overrides.end(), row.stated.begin(), row.stated.end());
    const Scene scene = LoadScene(file, overrides);
    const double rate = SensorRate(scene.sense);
    limits_ = scene.manipulator;
    const Samples none, &samples = row.follows_s ? none : SamplesOf(devices);
    const DrivenClock clock;
    std::optional<Site> site;
    if (row.follows_s) site.emplace(devices);
    const auto slave = MakeLiveSlave(scene);
    Devices hands(scene, *slave);
    auto next = row.events.begin();
    double t = 0;
    const std::size_t count =
        row.follows_s ? static_cast<std::size_t>(rate * *row.follows_s) : samples.size();
    for (std::size_t k = 0; k < count; ++k) {
      while (next != row.events.end() && next->at <= t + 1e-9) hands.Begin(*next++);
      seen_.push_back(site ? hands.Follow(static_cast<double>(k) / rate, &*site)
                           : hands.Send(samples[k]));
      t = seen_.back().t + 1 / rate;
      peak_ = std::max(peak_, VectorOf(seen_.back().truth.force()).norm());
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
    if (expected.error_by_sigma) CompareSigma(*expected.error_by_sigma, within);
    const auto largest = [&](const std::function<double(const Seen&)>& read) {
      double most = 0;
      for (const Seen* one : within) most = std::max(most, read(*one));
      return most;
    };
    const auto is_within = [](double value, const std::array<double, 2>& range) {
      EXPECT_GE(value, range[0]);
      EXPECT_LE(value, range[1]);
    };
    if (expected.guards) {
      SCOPED_TRACE("the largest force or depth, relative to its guard");
      const double ratio = largest([&](const Seen& one) {
        return std::max(one.force / limits_.force_guard, one.depth / limits_.depth_guard);
      });
      RecordProperty("guards", std::to_string(ratio));
      is_within(ratio, *expected.guards);
    }
    if (expected.depth_m) {
      SCOPED_TRACE("the largest depth of the tool");
      is_within(largest([](const Seen& one) { return one.depth; }), *expected.depth_m);
    }
    if (expected.off_target_m) {
      SCOPED_TRACE("the largest distance of the tool from where the operator leads it");
      is_within(largest([](const Seen& one) { return one.off_target; }), *expected.off_target_m);
    }
    if (expected.force_peak) {
      SCOPED_TRACE("the largest known force");
      const auto force = [](const Seen& one) {
        return one.state.force ? one.state.force->norm() : 0;
      };
      is_within(largest(force), *expected.force_peak);
    }
    if (expected.tip_travel_m) {
      const Eigen::Vector3d& first = within.front()->state.p_S_tip;
      EXPECT_GE(largest([&](const Seen& one) { return (one.state.p_S_tip - first).norm(); }),
                *expected.tip_travel_m);
    }
    if (expected.event) {
      const Event event = kEvents.at(*expected.event);
      EXPECT_TRUE(std::ranges::any_of(within, [&](const Seen* s) { return s->events.Has(event); }))
          << "no event " << *expected.event;
    }
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
    if (expected.never) EXPECT_NE(CheckOf(state), *expected.never) << seen.t << " s";
    if (expected.force_error && state.validity == Validity::kValid && state.force) {
      EXPECT_LE(ErrorOf(seen), *expected.force_error * peak_) << seen.t << " s";
    }
    if (expected.tip_error_m && state.validity != Validity::kTrackingLost) {
      EXPECT_LE((state.p_S_tip - VectorOf(seen.truth.p_s_tip())).norm(), *expected.tip_error_m)
          << seen.t << " s";
    }
    if (expected.age_s) {
      const double age = SecondsBetween(state.sensed_at, state.sent_at);
      EXPECT_GE(age, (*expected.age_s)[0]) << seen.t << " s";
      EXPECT_LE(age, (*expected.age_s)[1]) << seen.t << " s";
    }
    if (expected.sigma && IsForceKnown(state)) {
      EXPECT_GE(state.sigma, (*expected.sigma)[0]) << seen.t << " s";
      EXPECT_LE(state.sigma, (*expected.sigma)[1]) << seen.t << " s";
    }
  }

  void CompareSigma(const std::array<double, 2>& range,
                    const std::vector<const Seen*>& within) const {
    double squares = 0;
    int count = 0;
    for (const Seen* one : within) {
      const SlaveState& state = one->state;
      const bool touches = VectorOf(one->truth.force()).norm() > kContactShare * peak_;
      if (!touches || state.validity != Validity::kValid) continue;
      squares += std::pow(ErrorOf(*one) / state.sigma, 2);
      ++count;
    }
    ASSERT_GT(count, 0);
    EXPECT_GE(std::sqrt(squares / count), range[0]);
    EXPECT_LE(std::sqrt(squares / count), range[1]);
  }

  [[nodiscard]] static double ErrorOf(const Seen& seen) {
    return (*seen.state.force - VectorOf(seen.truth.force())).norm();
  }

  // Checks promises of the documentation that must hold for every state.
  void CompareAlways(const Row& row) const {
    Time last{};
    for (const Seen& seen : seen_) {
      SCOPED_TRACE(testing::Message() << "at " << seen.t << " s");
      const SlaveState& state = seen.state;
      const bool is_valid = state.validity == Validity::kValid;
      const bool is_lost =
          state.validity == Validity::kTrackingLost || state.validity == Validity::kFailed;
      if (is_lost) EXPECT_FALSE(state.force.has_value());
      if (state.validity == Validity::kExtrapolated) EXPECT_NE(state.check, FailedCheck::kNone);
      EXPECT_GE(state.sensed_at, last);
      last = state.sensed_at;
      if (!is_valid || !state.force) continue;
      EXPECT_TRUE(state.check == FailedCheck::kNone || state.check == FailedCheck::kArmFault)
          << CheckOf(state);
      EXPECT_TRUE(state.sigma >= 0 && std::isfinite(state.sigma)) << state.sigma;
      if (!row.is_blind) {
        EXPECT_LE(ErrorOf(seen), std::max(kSilentShare * peak_, kSilentSigmas * state.sigma));
      }
    }
  }

  std::vector<Seen> seen_;
  double peak_ = 0;  // of the true force [N]
  ManipulatorOptions limits_;
};

TEST_P(PromiseTest, IsKept) {
  const Row& row = GetParam();
  const int line = LineOf(row.page, row.promise);
  ASSERT_GT(line, 0) << row.page << " does not promise: " << row.promise;
  ASSERT_NO_THROW(Run(row));
  CompareAlways(row);
  for (const Expectation& expected : row.expected) {
    SCOPED_TRACE(testing::Message() << row.page.string() << ':' << line << ": " << row.promise
                                    << "; from " << expected.from << " s");
    Compare(expected);
  }
}

std::string PipelineOf(const std::filesystem::path& file) {
  const Scene scene = LoadScene(SourcePath("/" + file.string()), {});
  if (scene.sense.Find<Tactile>() != nullptr) return "fingertips";
  return HasStereoOrDepth(scene.sense) ? "points" : "camera";
}

// Codes of CHECKS, each with its pipelines.
std::multimap<std::string, std::string> StatedChecks() {
  std::ifstream page(SourcePath("/slave/CHECKS.md"));
  const std::regex row(R"(\| \d+ \| `(\w+)` \|[^|]*\| ([a-z, ]+) \|.*)");
  const std::regex word(R"([a-z]+)");
  std::multimap<std::string, std::string> checks;
  for (std::string line; std::getline(page, line);) {
    std::smatch found;
    if (!std::regex_match(line, found, row)) continue;
    const std::string pipelines = found[2];
    for (std::sregex_iterator it(pipelines.begin(), pipelines.end(), word), end; it != end; ++it) {
      checks.emplace(found[1], it->str());
    }
  }
  return checks;
}

// A row must flag each check in each of its pipelines, and a row must not.
TEST(PromiseTableTest, HasEachCheckTwice) {
  std::map<std::filesystem::path, std::string> pipelines;
  std::set<std::pair<std::string, std::string>> flagged, kept;  // code, pipeline
  std::set<std::string> undisturbed;                            // pipelines
  for (const Row& row : ReadRows(SourcePath("/tests/promises/promises.yaml"))) {
    if (!pipelines.contains(row.scene)) pipelines[row.scene] = PipelineOf(row.scene);
    const std::string& pipeline = pipelines[row.scene];
    for (const Expectation& expected : row.expected) {
      if (expected.check == "none" && expected.share == 1 && row.events.empty()) {
        undisturbed.insert(pipeline);
      }
      for (const std::string& by : {pipeline, std::string("manipulator")}) {
        if (expected.check) flagged.emplace(*expected.check, by);
        if (expected.never) kept.emplace(*expected.never, by);
      }
    }
  }
  const auto stated = StatedChecks();
  ASSERT_GT(stated.size(), 25U);
  for (const auto& check : stated) {
    EXPECT_TRUE(flagged.contains(check)) << check.first << ", " << check.second << ": not flagged";
    EXPECT_TRUE(kept.contains(check) || undisturbed.contains(check.second))
        << check.first << ", " << check.second << ": always flagged?";
  }
}

std::vector<Row> RowsOf(bool is_full) {
  auto rows = ReadRows(SourcePath("/tests/promises/promises.yaml"));
  std::erase_if(rows, [&](const Row& row) { return row.is_full != is_full; });
  return rows;
}

constexpr auto kName = [](const auto& row) { return row.param.name; };

INSTANTIATE_TEST_SUITE_P(Table, PromiseTest, testing::ValuesIn(RowsOf(false)), kName);
INSTANTIATE_TEST_SUITE_P(Full, PromiseTest, testing::ValuesIn(RowsOf(true)), kName);

}  // namespace
}  // namespace palpate::promises
