// The lease by itself, without a network.
#include <functional>
#include <thread>
#include <utility>
#include <vector>

#include <gtest/gtest.h>

#include "slave/service/operator_lease.h"
#include "tests/slave/service/service_fixture.h"

namespace palpate {
namespace {

// Longer than the delay of a busy machine between two statements.
constexpr std::chrono::milliseconds kSilence(1000);

void RunAtOnce(const std::function<void()>& task) {
  task();
}

class LeaseTest : public testing::Test {
 protected:
  OperatorLease::Ticket Take(const std::string& peer, std::string* dismissed = nullptr) {
    return TakeAs(std::nullopt, peer, dismissed);
  }
  OperatorLease::Ticket TakeAs(const std::optional<std::string>& name, const std::string& peer,
                               std::string* dismissed = nullptr) {
    const auto answer = lease_.RequestTicket(peer, name, [dismissed](const std::string& reason) {
      if (dismissed != nullptr) *dismissed = reason;
    });
    const auto* ticket = std::get_if<OperatorLease::Ticket>(&answer);
    return ticket != nullptr ? *ticket : 0;
  }

  FakeSlave slave_;
  OperatorLease lease_{slave_, kSilence, RunAtOnce, {}};
};

TEST_F(LeaseTest, CommandsOfAnOldTicketHaveNoEffect) {
  const auto old = Take("a");
  lease_.Release(old);
  const auto current = Take("b");
  ASSERT_NE(current, 0U);
  v1::OperatorCommand command;
  command.set_sequence(1);
  EXPECT_TRUE(lease_.Command(old, command));
  EXPECT_TRUE(slave_.commands().empty());
  lease_.Release(old);
  EXPECT_EQ(slave_.ends(), 1) << "an old ticket released the new lease";
  lease_.Command(current, command);
  EXPECT_EQ(slave_.commands().size(), 1U);
}

TEST_F(LeaseTest, CommandsContinueWhileAStopIsWrittenToDisk) {
  std::vector<std::function<void()>> waiting;
  OperatorLease lease(slave_, kSilence,
                      [&](std::function<void()> task) { waiting.push_back(std::move(task)); }, {});
  const auto answer = lease.RequestTicket("a", std::nullopt, [](const std::string&) {});
  v1::OperatorCommand command;
  command.set_stop(true);
  for (int sequence = 1; sequence <= 3; ++sequence) {
    command.set_sequence(static_cast<std::uint64_t>(sequence));
    EXPECT_TRUE(lease.Command(std::get<OperatorLease::Ticket>(answer), command));
    EXPECT_EQ(slave_.Status().phase, Phase::kEstop);
  }
  EXPECT_EQ(slave_.commands().size(), 3U);
  EXPECT_EQ(slave_.stop_reason(), "");
  ASSERT_EQ(waiting.size(), 1U) << "a stop is recorded once";
  waiting[0]();
  EXPECT_EQ(slave_.stop_reason(), "by the operator, an unnamed operator (a)");
}

TEST_F(LeaseTest, ASilentHolderLosesTheLeaseToTheNextClient) {
  std::string dismissed;
  ASSERT_NE(Take("silent", &dismissed), 0U);
  EXPECT_EQ(Take("eager"), 0U);
  EXPECT_TRUE(dismissed.empty());
  std::this_thread::sleep_for(kSilence);
  EXPECT_NE(Take("patient"), 0U);
  EXPECT_NE(dismissed.find("no command for too long: the lease was passed to patient"),
            std::string::npos);
  EXPECT_EQ(slave_.ends(), 1);
  EXPECT_EQ(slave_.begins(), 2);
}

// Malformed, refused and replayed commands arrive all the time: they do not keep the lease.
TEST_F(LeaseTest, OnlyValidNewerCommandsKeepTheLease) {
  const auto ticket = Take("broken");
  v1::OperatorCommand good, malformed, refused;
  good.set_sequence(7);
  refused.set_sequence(8);
  refused.mutable_p_m()->set_x(50);  // beyond the slave's workspace
  lease_.Command(ticket, good);
  const Time begin = Clock::now();
  while (Clock::now() - begin < kSilence) {
    for (const auto& command : {malformed, refused, good}) lease_.Command(ticket, command);
    std::this_thread::sleep_for(kSilence / 20);
  }
  EXPECT_NE(Take("patient"), 0U);
}

TEST_F(LeaseTest, OnlyAnEngagedHolderMayBeSilentForLong) {
  OperatorLease lease(slave_, kLiveness, RunAtOnce, {});
  const auto take = [&] { return lease.RequestTicket("other", {}, [](const auto&) {}).index(); };
  const auto ticket = std::get<OperatorLease::Ticket>(lease.RequestTicket("a", {}, {}));
  v1::OperatorCommand command;
  command.set_epoch(1);
  command.set_sequence(1);
  command.set_engaged(true);
  command.mutable_p_m()->set_y(0);
  lease.Command(ticket, command);
  std::this_thread::sleep_for(OperatorLease::kIdleSilence);
  EXPECT_EQ(take(), 1U) << "refused";
  command.set_sequence(2);
  command.set_engaged(false);
  lease.Command(ticket, command);
  EXPECT_EQ(take(), 1U) << "refused";
  std::this_thread::sleep_for(OperatorLease::kIdleSilence);
  EXPECT_EQ(take(), 0U) << "a ticket";
}

TEST_F(LeaseTest, AnEvictedOperatorMakesRoomForOthers) {
  EXPECT_THROW(lease_.Evict("nobody is here"), std::logic_error);
  std::string dismissed;
  const auto evicted = TakeAs("ada", "a", &dismissed);
  ASSERT_NE(evicted, 0U);
  lease_.Evict("the robot is needed");
  EXPECT_EQ(dismissed, "evicted by an administrator: the robot is needed");
  EXPECT_EQ(slave_.ends(), 1);
  ASSERT_NE(TakeAs("bob", "b"), 0U);
  lease_.Release(evicted);
  EXPECT_TRUE(lease_.IsHeldBy("b", {})) << "the evicted stream ends late";
  EXPECT_EQ(TakeAs("ada", "a"), 0U);
}

}  // namespace
}  // namespace palpate
