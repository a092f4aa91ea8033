// The installed libspnav, connected to a daemon of this test.
#include "master/device/spacemouse/spacemouse.h"

#include <array>
#include <cstdlib>
#include <cstring>

#include <gmock/gmock.h>
#include <gtest/gtest.h>
#include <sys/socket.h>
#include <sys/un.h>
#include <unistd.h>

#include "tests/support/allocation_count.h"

namespace palpate {
namespace {

using testing::HasSubstr;

const Time kSpaceMouseStart{std::chrono::hours(1)};
constexpr double kFullSpeed = 0.02;  // [m/s]
constexpr int kFullScale = 350;      // [counts]

// Speaks spacenavd's protocol 0: after the client's request for a newer one, each event is eight
// numbers of 4 bytes.
class Spacenavd {
 public:
  // Numbers of the protocol.
  static constexpr int kMotion = 0, kPress = 1, kRelease = 2, kDevice = 3, kRemoved = 1;

  Spacenavd() : listener_(socket(AF_UNIX, SOCK_STREAM, 0)) {
    sockaddr_un address{};
    address.sun_family = AF_UNIX;
    std::strncpy(address.sun_path, path().c_str(), sizeof(address.sun_path) - 1);
    const auto* const any = reinterpret_cast<const sockaddr*>(&address);
    EXPECT_EQ(bind(listener_, any, sizeof(address)), 0) << path();
    EXPECT_EQ(listen(listener_, 1), 0);
    setenv("SPNAV_SOCKET", path().c_str(), 1);
    thread_ = std::jthread([this] {
      client_ = accept(listener_, nullptr, nullptr);
      std::uint32_t request = 0;
      if (read(client_, &request, sizeof(request)) != sizeof(request)) return;
      const std::uint32_t answer = request & 0xFFFFFF00U;  // the version is the last byte
      EXPECT_EQ(write(client_, &answer, sizeof(answer)), static_cast<ssize_t>(sizeof(answer)));
    });
  }
  ~Spacenavd() {
    Close();
    close(listener_);
    unlink(path().c_str());
    unsetenv("SPNAV_SOCKET");
  }
  Spacenavd(const Spacenavd&) = delete;
  Spacenavd& operator=(const Spacenavd&) = delete;

  void WaitForClient() { thread_.join(); }
  void Send(std::array<int, 8> event) const {
    EXPECT_EQ(write(client_, event.data(), sizeof(event)), static_cast<ssize_t>(sizeof(event)));
  }
  void Close() {
    if (client_ >= 0) close(client_);
    client_ = -1;
  }

 private:
  static std::string path() {
    return testing::TempDir() + "palpate-spnav-" + std::to_string(getpid()) + ".sock";
  }

  int listener_, client_ = -1;
  std::jthread thread_;
};

class SpaceMouseTest : public testing::Test {
 protected:
  SpaceMouseTest() : device_(kFullSpeed, false) { daemon_.WaitForClient(); }

  // Ticks of 1 ms for `seconds`; the daemon is polled every 5 ms if it `polls`.
  DeviceReading Run(double seconds, bool polls = true) {
    DeviceReading reading;
    for (int i = 0; i < std::lround(1000 * seconds); ++i, ++ms_) {
      const Time now = kSpaceMouseStart + std::chrono::milliseconds(ms_);
      if (polls && ms_ % 5 == 0) device_.Poll(now);
      reading = device_.Read(now);
      device_.WriteForce(force_);
    }
    return reading;
  }
  void Engage() { daemon_.Send({Spacenavd::kPress, 7}); }
  void Deflect(int x, int y, int z) { daemon_.Send({Spacenavd::kMotion, x, y, z}); }

  Spacenavd daemon_;
  SpaceMouse device_;
  Eigen::Vector3d force_{0, 0, 0};
  int ms_ = 0;
};

// Reference: a deflection lasts 0.25 s after its event, and one poll more. The library's z points
// away from the operator.
TEST_F(SpaceMouseTest, MovesAtTheCommandedVelocityWhileTheFirstButtonIsPressed) {
  constexpr double kLasts = 0.255;  // [s]
  Deflect(kFullScale, 0, kFullScale);
  EXPECT_EQ(Run(0.1).p_M, Eigen::Vector3d::Zero());
  Run(0.3);
  Engage();
  EXPECT_TRUE(Run(0.1).engaged);
  Deflect(kFullScale, 0, kFullScale);
  const DeviceReading moved = Run(1);
  EXPECT_NEAR(moved.p_M.x(), kLasts * kFullSpeed, 1e-6);
  EXPECT_NEAR(moved.p_M.z(), -kLasts * kFullSpeed, 1e-6);
  EXPECT_EQ(moved.p_M.y(), 0);
  daemon_.Send({Spacenavd::kPress, 2});
  EXPECT_EQ(Run(0.1).status.buttons, 3U);
  daemon_.Send({Spacenavd::kRelease, 7});
  const DeviceReading released = Run(0.1);
  EXPECT_FALSE(released.engaged);
  EXPECT_EQ(released.status.buttons, 2U);
}

TEST_F(SpaceMouseTest, IgnoresACapAtRest) {
  Engage();
  Deflect(kFullScale / 14, -kFullScale / 14, 0);
  EXPECT_EQ(Run(0.2).p_M, Eigen::Vector3d::Zero());
}

TEST_F(SpaceMouseTest, YieldsToTheForce) {
  Engage();
  force_ = {0, 3, 0};
  EXPECT_NEAR(Run(2).p_M.y(), 3 / Arm().stiffness, 1e-6);
}

// Reference: the motion ends after 20 ms of silence, the engagement after 100 ms.
TEST_F(SpaceMouseTest, ASilentSourceStopsTheMotionAndThenDisengages) {
  Engage();
  Run(0.1);
  Deflect(kFullScale, 0, 0);
  Run(0.1);
  const double before = Run(0.090, false).p_M.x();
  EXPECT_GT(before, 0);
  EXPECT_NEAR(Run(0.005, false).p_M.x(), before, 1e-4);
  const DeviceReading silent = Run(0.020, false);
  EXPECT_EQ(silent.status.fault, DeviceFault::kSilent);
  EXPECT_FALSE(silent.engaged);
  EXPECT_FALSE(Run(0.1).engaged) << "the switch was never opened";
}

TEST_F(SpaceMouseTest, ReportsItsRemovalAndTheEndOfTheDaemon) {
  Engage();
  EXPECT_TRUE(Run(0.1).engaged);
  daemon_.Send({Spacenavd::kDevice, Spacenavd::kRemoved});
  const DeviceReading removed = Run(0.01);
  EXPECT_FALSE(removed.engaged);
  EXPECT_EQ(FaultInWords(removed.status), "unplugged: spacenavd reports its removal");
  daemon_.Close();
  EXPECT_EQ(FaultInWords(Run(0.01).status), "unplugged: spacenavd has closed the connection");
}

TEST_F(SpaceMouseTest, ReadingAndWritingDoNotAllocate) {
  Engage();
  Run(0.1);
  force_ = {1, 2, 3};
  const long before = AllocationCount();
  Run(1, false);
  EXPECT_EQ(AllocationCount(), before);
}

TEST(SpaceMouseDriverTest, SaysThatTheDaemonIsMissing) {
  setenv("SPNAV_SOCKET", "/nonexistent/spnav.sock", 1);
  const DriverReport report = SpaceMouseDriver().examine();
  unsetenv("SPNAV_SOCKET");
  EXPECT_FALSE(report.usable);
  EXPECT_THAT(report.missing, testing::ElementsAre(HasSubstr("spacenavd does not answer")));
  EXPECT_THAT(report.next, HasSubstr("apt-get install libspnav0 spacenavd"));
}

}  // namespace
}  // namespace palpate
