#include "tests/robustness/mixed.h"

#include <set>
#include <string>

#include <gtest/gtest.h>

namespace palpate::robustness {
namespace {

Case Named(const std::string& name) {
  Case named;
  named.name = name;
  return named;
}

TEST(MixedTest, BothAlterationsActOneAfterTheOther) {
  Alteration first, second;
  first.touch = [](const Moment&, TactileFrame& frame) { frame.sequence += 1; };
  second.touch = [](const Moment&, TactileFrame& frame) { frame.sequence *= 10; };
  first.loses = [](const Moment& moment) { return moment.index == 3; };
  second.loses = [](const Moment& moment) { return moment.index == 5; };
  second.object_moves = [](const Moment&) { return Eigen::Vector2d(1, 2); };
  first.arm_error = 2;
  const Alteration both = Both(first, second);
  TactileFrame frame;
  both.touch({}, frame);
  EXPECT_EQ(frame.sequence, 10U);
  for (const std::size_t index : {3U, 4U, 5U}) EXPECT_EQ(both.loses({{}, index}), index != 4);
  EXPECT_EQ(both.object_moves({}), Eigen::Vector2d(1, 2));
  EXPECT_EQ(both.arm_error, 2);
  EXPECT_FALSE(both.paint) << "there is none";
}

TEST(MixedTest, PairsAreDrawnOnceAndTheSameByTheSameSeed) {
  std::vector<Case> cases = {Named("a"), Named("b"), Named("c"), Named("late"), Named("frozen")};
  cases[3].alteration.shows = Late(2);
  cases[4].alteration.shows = Frozen(When::kAtRest);
  const std::vector<Case> mixed = Mixed(cases, 100, 1);
  std::set<std::string> names;
  for (const Case& one : mixed) names.insert(one.name);
  EXPECT_EQ(names.size(), mixed.size());
  EXPECT_EQ(mixed.size(), 18U) << "of 20, without those that would show two samples at once";
  const std::vector<Case> again = Mixed(cases, 3, 1), others = Mixed(cases, 3, 2);
  EXPECT_EQ(again[0].name, mixed[0].name);
  EXPECT_NE(again[0].name + again[1].name + again[2].name,
            others[0].name + others[1].name + others[2].name);
}

}  // namespace
}  // namespace palpate::robustness
