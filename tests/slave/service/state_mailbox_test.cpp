#include "slave/service/state_mailbox.h"

#include <thread>

#include <gtest/gtest.h>

namespace palpate {
namespace {

using std::chrono::milliseconds;

SlaveState State(std::uint64_t sequence) {
  SlaveState state;
  state.sequence = sequence;
  return state;
}

TEST(StateMailboxTest, EventsOfSkippedStatesArriveWithTheNextOne) {
  StateMailbox box;
  SlaveState state = State(1);
  state.events.Add(Event::kContact);
  box.Put(state);
  box.Put(State(2));
  state = State(3);
  state.events.Add(Event::kRelease);
  box.Put(state);
  const auto taken = box.TakeNewest();
  EXPECT_TRUE(taken->events.Has(Event::kContact));
  EXPECT_TRUE(taken->events.Has(Event::kRelease));
  box.Put(State(4));
  EXPECT_TRUE(box.TakeNewest()->events.empty()) << "sent twice";
}

TEST(StateMailboxTest, ClosingWakesWhoeverWaitsAndPauses) {
  StateMailbox box;
  std::jthread waiting([&] { EXPECT_FALSE(box.WaitNewest(std::chrono::seconds(60)).has_value()); });
  box.Close();
  waiting.join();
  box.PauseUntil(Clock::now() + std::chrono::seconds(60));
  box.Put(State(1));
  EXPECT_FALSE(box.WaitNewest(std::chrono::seconds(60)).has_value());
  EXPECT_TRUE(box.closed());
}

// One writer, one reader, no state in between counted twice: sequences rise, every event arrives.
TEST(StateMailboxTest, AcrossThreadsSequencesRiseAndEveryEventArrives) {
  constexpr std::uint64_t kLast = 50'000;
  StateMailbox box;
  std::jthread writer([&] {
    for (std::uint64_t i = 1; i <= kLast; ++i) {
      SlaveState state = State(i);
      if (i == kLast / 2) state.events.Add(Event::kPuncture);
      box.Put(state);
    }
  });
  std::uint64_t seen = 0, punctures = 0;
  while (seen < kLast) {
    const auto state = box.WaitNewest(milliseconds(100));
    if (!state) continue;
    ASSERT_GT(state->sequence, seen);
    seen = state->sequence;
    punctures += state->events.Has(Event::kPuncture) ? 1U : 0U;
  }
  EXPECT_EQ(punctures, 1U);
}

}  // namespace
}  // namespace palpate
