#include <array>
#include <cstdint>
#include <cstring>
#include <string>
#include <vector>

#include <gtest/gtest.h>
#include <poll.h>
#include <sys/socket.h>
#include <sys/un.h>
#include <unistd.h>

#include "tests/master/device/fakes/fake_library.h"

namespace palpate::fakes {
namespace {

// The vendor's event: its type, then seven to nine numbers, as that type says.
struct Event {
  int type;
  int numbers[11];
};

class SpnavTest : public testing::Test {
 protected:
  Library lib{"spnav", "libspnav.so"};
  int (*open)() = lib.Find<int()>("spnav_open");
  int (*close)() = lib.Find<int()>("spnav_close");
  int (*fd)() = lib.Find<int()>("spnav_fd");
  int (*poll_event)(Event*) = lib.Find<int(Event*)>("spnav_poll_event");

  void SetUp() override { lib.set_clock(0); }
  std::vector<Event> Events() const {
    std::vector<Event> found;
    for (Event event{}; poll_event(&event) > 0;) found.push_back(event);
    return found;
  }
};

TEST_F(SpnavTest, ReportsDeflectionInCountsAndItsEndOnce) {
  ASSERT_EQ(open(), 0);
  EXPECT_EQ(open(), -1) << "once only";
  lib.step(0.1);
  EXPECT_TRUE(Events().empty()) << "silent at rest";
  const FakeKnot pushed[] = {{0, 0.002, -0.001, 0}};
  lib.follow(pushed, 1, 0);
  lib.step(0.064);
  const std::vector<Event> motion = Events();
  ASSERT_GE(motion.size(), 3u);
  EXPECT_EQ(motion[1].type, 1);
  EXPECT_EQ(motion[1].numbers[0], 350);
  EXPECT_EQ(motion[1].numbers[1], -175);
  EXPECT_EQ(motion[1].numbers[6], 16) << "[ms]";
  lib.follow(nullptr, 0, 0);
  lib.step(1);
  const std::vector<Event> end = Events();
  ASSERT_FALSE(end.empty());
  EXPECT_EQ(end.back().numbers[0], 0);
  EXPECT_LT(end.size(), 30u) << "silent again";
}

TEST_F(SpnavTest, ButtonNumbersHaveHoles) {
  ASSERT_EQ(open(), 0);
  lib.press(23, 1, 0.01);
  lib.press(23, 0, 0.02);
  lib.step(0.03);
  const std::vector<Event> events = Events();
  ASSERT_EQ(events.size(), 2u);
  EXPECT_EQ(events[0].type, 2);
  EXPECT_EQ(events[0].numbers[0], 1);
  EXPECT_EQ(events[0].numbers[1], 23);
  EXPECT_EQ(events[1].numbers[0], 0);
}

TEST_F(SpnavTest, APulledPlugLeavesTheLastDeflection) {
  ASSERT_EQ(open(), 0);
  const FakeKnot pushed[] = {{0, 0.002, 0, 0}};
  lib.follow(pushed, 1, 0);
  lib.step(0.05);
  Events();
  lib.unplug();
  lib.step(1);
  const std::vector<Event> events = Events();
  ASSERT_EQ(events.size(), 1u);
  EXPECT_EQ(events[0].type, 3);
  EXPECT_EQ(events[0].numbers[0], 1) << "removed";
  lib.replug();
  lib.step(0.02);
  const std::vector<Event> again = Events();
  ASSERT_GE(again.size(), 2u);
  EXPECT_EQ(again[0].numbers[0], 0) << "added";
  EXPECT_EQ(again[1].numbers[0], 350);
}

TEST_F(SpnavTest, ADaemonThatEndsIsSeenOnlyAtTheFileDescriptor) {
  ASSERT_EQ(open(), 0);
  lib.set_option("daemon", "0");
  EXPECT_TRUE(Events().empty());
  pollfd wait{fd(), POLLIN, 0};
  ASSERT_EQ(::poll(&wait, 1, 0), 1);
  char byte = 0;
  EXPECT_EQ(recv(fd(), &byte, 1, 0), 0) << "end of the connection";
  EXPECT_EQ(close(), 0);
  EXPECT_EQ(open(), -1);
}

// As the real library speaks to the daemon: protocol, device's name, then events of 32 bytes.
TEST_F(SpnavTest, TheDaemonIsReachedThroughASocket) {
  lib.reset();
  const std::string path = testing::TempDir() + "/spnav_test.sock";
  ASSERT_EQ(lib.set_option("socket", path.c_str()), 0);
  const int client = socket(AF_UNIX, SOCK_STREAM, 0);
  sockaddr_un address{};
  address.sun_family = AF_UNIX;
  std::strncpy(address.sun_path, path.c_str(), sizeof address.sun_path - 1);
  ASSERT_EQ(connect(client, reinterpret_cast<sockaddr*>(&address), sizeof address), 0);
  std::int32_t word = 0x7faa0000 | 0x5500 | 1;
  ASSERT_EQ(send(client, &word, sizeof word, 0), 4);
  ASSERT_EQ(recv(client, &word, sizeof word, MSG_WAITALL), 4);
  EXPECT_EQ(word & 0xff, 1);
  std::array<std::int32_t, 8> packet{0x7faa2000};
  ASSERT_EQ(send(client, packet.data(), sizeof packet, 0), 32);
  ASSERT_EQ(recv(client, packet.data(), sizeof packet, MSG_WAITALL), 32);
  EXPECT_EQ(std::string(reinterpret_cast<char*>(&packet[1]), 14), "SpaceMouse Pro");
  lib.press(12, 1, 0);
  ASSERT_EQ(recv(client, packet.data(), sizeof packet, MSG_WAITALL), 32);
  EXPECT_EQ(packet[0], 1);
  EXPECT_EQ(packet[1], 12);
  ::close(client);
}

}  // namespace
}  // namespace palpate::fakes
