#include <set>
#include <stdexcept>
#include <utility>

#include <gtest/gtest.h>

#include "slave/tactile/recordings/labelled_recording.h"
#include "tests/slave/tactile/training/synthetic_recordings.h"

namespace palpate {
namespace {

using testing::SyntheticRecording;

// One press alone has rest enough around it to be cut twice.
std::vector<LabelledRecording> Recordings(int count, int presses) {
  const int rest = count * presses == 1 ? 500 : 100;
  std::vector<LabelledRecording> recordings;
  for (int i = 0; i < count; ++i) {
    recordings.push_back(SyntheticRecording(presses, static_cast<std::uint32_t>(i), rest));
  }
  return recordings;
}

// Every sample that a part's windows of 50 contain.
std::set<std::pair<std::size_t, std::size_t>> SamplesOf(const std::vector<Stretch>& part) {
  std::set<std::pair<std::size_t, std::size_t>> samples;
  for (const Window& w : WindowsOf(part, 50)) {
    for (std::size_t i = w.last - 49; i <= w.last; ++i) samples.insert({w.recording, i});
  }
  return samples;
}

std::size_t Shared(const std::vector<Stretch>& a, const std::vector<Stretch>& b) {
  std::size_t shared = 0;
  const auto in_b = SamplesOf(b);
  for (const auto& sample : SamplesOf(a)) shared += in_b.count(sample);
  return shared;
}

TEST(FindPressesTest, CutsInTheMiddleOfTheQuietBetween) {
  const auto recordings = Recordings(1, 3);
  const std::vector<Stretch> presses = FindPresses(recordings);
  ASSERT_EQ(presses.size(), 3U);
  EXPECT_EQ(presses[0].begin, 0U);
  EXPECT_EQ(presses[2].end, 1200U);
  for (std::size_t i = 0; i < 2; ++i) {
    EXPECT_EQ(presses[i].end, presses[i + 1].begin);
    EXPECT_EQ(presses[i + 1].look_back, presses[i + 1].begin);
    // The sine is below 5 % of its peak for 3 of 200 samples at each end.
    EXPECT_NEAR(static_cast<double>(presses[i].end), 400.0 * static_cast<double>(i + 1), 12);
  }
}

TEST(FindPressesTest, OnlyTheWantedInstantsAreLookedAt) {
  auto recordings = Recordings(1, 3);
  recordings[0].begin = 400;
  recordings[0].end = 800;
  const std::vector<Stretch> presses = FindPresses(recordings);
  ASSERT_EQ(presses.size(), 1U);
  EXPECT_EQ(presses[0].begin, 400U);
  EXPECT_EQ(presses[0].end, 800U);
  EXPECT_EQ(presses[0].look_back, 400U);
}

TEST(WindowsOfTest, LookBackNoFurtherThanTheyMay) {
  const std::vector<Stretch> stretches{{0, 10, 100, 0}, {1, 200, 210, 190}};
  const std::vector<Window> windows = WindowsOf(stretches, 20);
  ASSERT_EQ(windows.size(), 81U + 1U);
  EXPECT_EQ(windows.front().last, 19U);
  EXPECT_EQ(windows.back().recording, 1U);
  EXPECT_EQ(windows.back().last, 209U);
}

struct Shape {
  int recordings, presses;
};

class SplitTest : public ::testing::TestWithParam<Shape> {};

TEST_P(SplitTest, NoSampleIsInTwoParts) {
  const auto recordings = Recordings(GetParam().recordings, GetParam().presses);
  for (const std::uint64_t seed : {1U, 2U, 3U}) {
    const Split split = SplitContacts(recordings, false, seed);
    EXPECT_FALSE(SamplesOf(split.train).empty());
    EXPECT_FALSE(SamplesOf(split.validation).empty());
    EXPECT_FALSE(SamplesOf(split.test).empty());
    EXPECT_EQ(Shared(split.train, split.test), 0U) << split.how;
    EXPECT_EQ(Shared(split.train, split.validation), 0U) << split.how;
    EXPECT_EQ(Shared(split.validation, split.test), 0U) << split.how;
  }
}

TEST_P(SplitTest, TheSameSeedSplitsInTheSameWay) {
  const auto recordings = Recordings(GetParam().recordings, GetParam().presses);
  EXPECT_EQ(SamplesOf(SplitContacts(recordings, false, 7).test),
            SamplesOf(SplitContacts(recordings, false, 7).test));
}

TEST_P(SplitTest, NothingIsSetAsideForATestThatIsApart) {
  const auto recordings = Recordings(GetParam().recordings, GetParam().presses);
  EXPECT_TRUE(SplitContacts(recordings, true, 1).test.empty());
}

INSTANTIATE_TEST_SUITE_P(Shapes, SplitTest,
                         ::testing::Values(Shape{1, 1}, Shape{1, 2}, Shape{1, 3}, Shape{2, 3},
                                           Shape{5, 1}, Shape{6, 3}, Shape{1, 20}));

// The paper's shares: of 20 recordings 4 test, of the other 16 round(3.2) = 3 validate.
TEST(SplitContactsTest, SharesAreThePapersByWholeRecordings) {
  const auto recordings = Recordings(20, 2);
  const Split split = SplitContacts(recordings, false, 1);
  const auto count = [](const std::vector<Stretch>& part) {
    std::set<std::size_t> used;
    for (const Stretch& s : part) used.insert(s.recording);
    return used.size();
  };
  EXPECT_EQ(count(split.test), 4U);
  EXPECT_EQ(count(split.validation), 3U);
  EXPECT_EQ(count(split.train), 13U);
  EXPECT_NE(split.how.find("by whole recordings"), std::string::npos) << split.how;
}

TEST(SplitContactsTest, ATestOnTheTrainedPressIsSaid) {
  EXPECT_NE(SplitContacts(Recordings(1, 1), false, 1).how.find("flatter"), std::string::npos);
  EXPECT_EQ(SplitContacts(Recordings(1, 4), false, 1).how.find("flatter"), std::string::npos);
}

// Four seconds alone cannot be cut into parts of more than a window: they are not.
TEST(SplitContactsTest, AShortPressIsNotCutToPieces) {
  const std::vector<LabelledRecording> recordings{SyntheticRecording(1, 1)};
  EXPECT_TRUE(SplitContacts(recordings, false, 1).validation.empty());
}

TEST(SplitContactsTest, RecordingsWithoutContactAreRefused) {
  auto recordings = Recordings(1, 1);
  for (auto& f : recordings[0].force) f.setZero();
  EXPECT_THROW(SplitContacts(recordings, false, 1), std::invalid_argument);
}

}  // namespace
}  // namespace palpate
