#include "master/trials/trial_plan.h"

#include <cmath>
#include <map>
#include <set>
#include <string>
#include <vector>

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include "shared/text/text.h"
#include "tests/support/scratch.h"

namespace palpate {
namespace {

using testing::HasSubstr;

class TrialPlanTest : public FolderTest {
 protected:
  // Labels of a plan, in order.
  static std::vector<std::string> Order(const std::filesystem::path& file, std::uint64_t seed) {
    std::vector<std::string> order;
    for (const Trial& trial : ReadTrials(file, seed)) {
      EXPECT_EQ(trial.label.number, order.size() + 1);
      EXPECT_EQ(trial.label.view(), trial.condition.label);
      order.push_back(trial.condition.label);
    }
    return order;
  }
};

TEST_F(TrialPlanTest, TheSameSeedGivesTheSameOrder) {
  const auto file = Write("t.csv", "label,seconds,repeats\na,1,5\nb,2,5\nc,3,5\n");
  std::set<std::vector<std::string>> orders;
  for (std::uint64_t seed = 0; seed < 50; ++seed) {
    const auto order = Order(file, seed);
    EXPECT_EQ(order, Order(file, seed));
    orders.insert(order);
    std::map<std::string, int> counts;
    for (const auto& label : order) ++counts[label];
    EXPECT_EQ(counts, (std::map<std::string, int>{{"a", 5}, {"b", 5}, {"c", 5}}));
  }
  EXPECT_GT(orders.size(), 45U) << "and another seed another one";
}

// Reference: mt19937_64 with seed 1 and Fisher-Yates, computed apart from this code (Python).
TEST_F(TrialPlanTest, TheOrderIsTheSameOnEveryMachine) {
  const auto file = Write("t.csv", "label,seconds\na,1\nb,1\nc,1\nd,1\ne,1\nf,1\n");
  EXPECT_EQ(Order(file, 1), (std::vector<std::string>{"b", "d", "a", "e", "f", "c"}));
}

// Reference: each of the six orders of three with probability 1/6; five standard deviations.
TEST_F(TrialPlanTest, EveryOrderIsEquallyLikely) {
  const auto file = Write("t.csv", "label,seconds\na,1\nb,1\nc,1\n");
  constexpr int kDraws = 3000;
  std::map<std::vector<std::string>, int> counts;
  for (std::uint64_t seed = 0; seed < kDraws; ++seed) ++counts[Order(file, seed)];
  ASSERT_EQ(counts.size(), 6U);
  const double mean = kDraws / 6.0, deviation = std::sqrt(kDraws * (1 / 6.0) * (5 / 6.0));
  for (const auto& [order, count] : counts) EXPECT_NEAR(count, mean, 5 * deviation);
}

TEST_F(TrialPlanTest, ReadsEverySetting) {
  const auto file = Write("t.csv",
                          "label,seconds,render,operator.position_scale,operator.force_scale,"
                          "object.material.young_modulus,model.kind\n"
                          "soft,20,hold,0.5,2,1e4,plate\n");
  const TrialCondition condition = ReadTrials(file, 0).front().condition;
  EXPECT_EQ(condition.seconds, 20);
  EXPECT_EQ(condition.render, RenderMode::kHold);
  EXPECT_EQ(condition.position_scale, 0.5);
  EXPECT_EQ(condition.force_scale, 2);
  EXPECT_EQ(condition.young_modulus, 1e4);
  EXPECT_EQ(condition.model_kind, "plate");
}

TEST_F(TrialPlanTest, RejectsWithLineColumnAndWhatIsAccepted) {
  const std::vector<std::pair<std::string, std::string>> cases{
      {"label\na\n", "seconds"},
      {"label,seconds\n", "t.csv"},
      {"label,seconds\na,0\n", "t.csv:2: seconds = 0: accepted is above 0"},
      {"label,seconds\na,nan\n", "t.csv:2: seconds"},
      {"label,seconds\na,1\na,1\n", "t.csv:3: label = a: accepted is one row per label"},
      {"label,seconds\na b,1\n", "label = a b: accepted is 1 to 31 letters"},
      {"label,seconds\n" + std::string(32, 'a') + ",1\n", "accepted is 1 to 31 letters"},
      {"label,seconds,repeats\na,1,1.5\n", "accepted is a whole number from 1 to 1000"},
      {"label,seconds,render\na,1,best\n", "accepted is local, interpolate or hold"},
      {"label,seconds,operator.force_scale\na,1,\n", "accepted is a number above 0"},
      {"label,seconds,operator.force_scale\na,1,-2\n", "accepted is a number above 0"},
      {"label,seconds,model.kind\na,1,\n", "model.kind"},
      {"label,seconds,object.geometry\na,1,2\n", "object.geometry"}};
  for (const auto& [text, expected] : cases) {
    const auto file = Write("t.csv", text);
    try {
      ReadTrials(file, 1);
      ADD_FAILURE() << text;
    } catch (const InputError& error) {
      EXPECT_THAT(error.what(), HasSubstr(expected));
    }
  }
}

}  // namespace
}  // namespace palpate
