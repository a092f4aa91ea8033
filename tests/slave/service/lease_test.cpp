// The lease by itself, without a network.
#include <thread>

#include <gtest/gtest.h>

#include "slave/service/operator_lease.h"
#include "tests/slave/service/fake_slave.h"

namespace palpate {
namespace {

// Long against what a busy machine takes from one line to the next.
constexpr std::chrono::milliseconds kSilence(1000);

class LeaseTest : public testing::Test {
 protected:
  OperatorLease::Ticket Take(const std::string& peer, std::string* dismissed = nullptr) {
    const auto answer = lease_.RequestTicket(peer, [dismissed](const std::string& reason) {
      if (dismissed != nullptr) *dismissed = reason;
    });
    const auto* ticket = std::get_if<OperatorLease::Ticket>(&answer);
    return ticket != nullptr ? *ticket : 0;
  }

  FakeSlave slave_;
  OperatorLease lease_{slave_, kSilence};
};

TEST_F(LeaseTest, CommandsOfAnOldTicketReachNobody) {
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

TEST_F(LeaseTest, ASilentHolderGivesWayToTheNextWhoAsks) {
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

// A malformed command, a refused one and a replayed one come all the time: they keep nothing.
TEST_F(LeaseTest, OnlyValidNewerCommandsKeepTheLease) {
  const auto ticket = Take("broken");
  v1::OperatorCommand good, malformed, refused;
  good.set_sequence(7);
  refused.set_sequence(8);
  refused.mutable_p_m()->set_x(50);  // farther than the slave goes
  lease_.Command(ticket, good);
  const Time begin = Clock::now();
  while (Clock::now() - begin < kSilence) {
    for (const auto& command : {malformed, refused, good}) lease_.Command(ticket, command);
    std::this_thread::sleep_for(kSilence / 20);
  }
  EXPECT_NE(Take("patient"), 0U);
}

TEST_F(LeaseTest, ANameIsCutBetweenCharactersAndNotWithinOne) {
  const auto ticket = Take("a");
  v1::OperatorCommand command;
  command.set_sequence(1);
  std::string name;
  for (int i = 0; i < 70; ++i) name += "\xC3\xA9";  // e with an acute accent: two bytes
  command.set_operator_name(name);
  lease_.Command(ticket, command);
  EXPECT_EQ(lease_.holder_name(), name.substr(0, 128));
}

}  // namespace
}  // namespace palpate
