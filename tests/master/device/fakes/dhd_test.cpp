#include <cmath>
#include <cstdlib>
#include <cstring>
#include <string>

#include <gtest/gtest.h>
#include <sys/socket.h>
#include <sys/un.h>
#include <unistd.h>

#include "tests/master/device/fakes/fake_library.h"

namespace palpate::fakes {
namespace {

class DhdTest : public testing::Test {
 protected:
  Library lib{"dhd", "libdhd.so"};
  template <class F>
  F* At(const char* name) {
    return lib.Find<F>(name);
  }
  using Get3 = int(double*, double*, double*, char);
  int (*open)() = At<int()>("dhdOpen");
  int (*close)(char) = At<int(char)>("dhdClose");
  int (*last_error)() = At<int()>("dhdErrorGetLast");
  int (*enable)(unsigned char, char) = At<int(unsigned char, char)>("dhdEnableForce");
  Get3* position = At<Get3>("dhdGetPosition");
  Get3* velocity = At<Get3>("dhdGetLinearVelocity");
  int (*configure_velocity)(int, int, char) = At<int(int, int, char)>("dhdConfigLinearVelocity");
  int (*set_force)(double, double, double,
                   char) = At<int(double, double, double, char)>("dhdSetForce");
  int (*set_all)(double, double, double, double, double, double, double, char) =
      At<int(double, double, double, double, double, double, double, char)>(
          "dhdSetForceAndTorqueAndGripperForce");
  int (*set_max_force)(double, char) = At<int(double, char)>("dhdSetMaxForce");
  int (*gravity)(int, char) = At<int(int, char)>("dhdSetGravityCompensation");
  int (*get_status)(int*, char) = At<int(int*, char)>("dhdGetStatus");
  int (*frame)(double[3][3], char) = At<int(double[3][3], char)>("dhdGetOrientationFrame");
  int (*gap)(double*, char) = At<int(double*, char)>("dhdGetGripperGap");

  double x = 0, y = 0, z = 0;
  int status[64] = {};

  void SetUp() override { lib.set_clock(0); }
  void Open(const char* model, bool forces) {
    lib.set_option("model", model);
    ASSERT_EQ(open(), 0);
    if (forces) {
      ASSERT_EQ(enable(1, -1), 0);
    }
  }
  int Cause() {
    get_status(status, -1);
    return status[5] ? -1 : status[14];
  }
  double Made() {
    double f[3];
    lib.last_force(f);
    return std::hypot(f[0], f[1], f[2]);
  }
};

// Reference: Newton; no friction, and gravity is compensated.
TEST_F(DhdTest, AForceMovesTheHandleOnceForcesAreEnabled) {
  lib.set_option("viscosity", "0");
  lib.set_option("dry", "0");
  Open("omega.3", false);
  gravity(1, -1);
  EXPECT_EQ(set_force(1, 0, 0, -1), 0) << "accepted";
  EXPECT_EQ(Made(), 0) << "without effect";
  enable(1, -1);
  set_force(1, 0, 0, -1);
  lib.step(0.05);
  double p[3], v[3];
  lib.get_handle(p, v);
  EXPECT_NEAR(p[0], 0.05 * 0.05 / (2 * 0.22), 1e-6);
  EXPECT_EQ(p[2], 0);
}

// Without compensation the handle falls at g; with motors off the brakes let it sink at m g / b.
TEST_F(DhdTest, WeightAndBrakesActAsDocumented) {
  lib.set_option("viscosity", "0");
  lib.set_option("dry", "0");
  Open("omega.3", true);
  gravity(0, -1);
  set_force(0, 0, 0, -1);
  double p[3], v[3];
  lib.step(0.05);
  lib.get_handle(p, v);
  EXPECT_NEAR(p[2], -9.81 * 0.05 * 0.05 / 2, 1e-6);
  lib.place(0, 0, 0.08);
  lib.step(1);
  lib.get_handle(p, v);
  EXPECT_NEAR(v[2], -0.22 * 9.81 / 20, 1e-3);
}

TEST_F(DhdTest, ASecondReadWithinAPeriodRepeatsTheFirst) {
  Open("omega.3", false);
  lib.place(0.01, 0, 0);
  EXPECT_EQ(position(&x, &y, &z, -1), 0);
  lib.place(0.02, 0, 0);
  EXPECT_EQ(position(&x, &y, &z, -1), 1);
  EXPECT_DOUBLE_EQ(x, 0.01);
  lib.step(0.001);
  EXPECT_EQ(position(&x, &y, &z, -1), 0);
  EXPECT_DOUBLE_EQ(x, 0.02);
}

TEST_F(DhdTest, ForcesBeyondTheMotorsAreSaturated) {
  Open("falcon", true);
  EXPECT_EQ(set_force(0, 30, 0, -1), 2);
  EXPECT_DOUBLE_EQ(Made(), 8);
  EXPECT_EQ(set_max_force(2, -1), 0);
  EXPECT_EQ(set_force(0, 3, 0, -1), 2);
  EXPECT_DOUBLE_EQ(Made(), 2);
  EXPECT_EQ(set_force(NAN, 0, 0, -1), -1);
  EXPECT_DOUBLE_EQ(Made(), 2) << "the one before holds";
}

TEST_F(DhdTest, ForcesEndWithoutCommands) {
  Open("omega.3", true);
  set_force(1, 0, 0, -1);
  lib.step(0.099);
  EXPECT_EQ(Made(), 1);
  lib.step(0.002);
  EXPECT_EQ(Made(), 0);
  EXPECT_EQ(Cause(), 3);
  EXPECT_EQ(set_force(1, 0, 0, -1), 0) << "nothing tells but the status";
  EXPECT_EQ(Made(), 0);
  enable(1, -1);
  set_force(1, 0, 0, -1);
  EXPECT_EQ(Made(), 1);
}

TEST_F(DhdTest, TheStatusIsLongAndSaysWhyForcesAreOff) {
  Open("sigma.7", true);
  status[17] = 4711;
  EXPECT_EQ(Cause(), -1);
  EXPECT_EQ(status[16], 7);
  EXPECT_EQ(status[17], 4711);
  enable(0, -1);
  EXPECT_EQ(Cause(), 4);
  enable(1, -1);
  lib.set_option("force_button", "1");
  EXPECT_EQ(Cause(), 1);
  EXPECT_EQ(enable(1, -1), -1);
  lib.set_option("force_button", "0");
  enable(1, -1);
  lib.set_option("deadman", "0");
  EXPECT_EQ(Cause(), 6);
  lib.set_option("deadman", "1");
  enable(1, -1);
  lib.set_option("grip_stiffness", "inf");
  const FakeKnot quick[] = {{0, 0, 0, 0}, {0.02, 0.05, 0, 0}};
  lib.follow(quick, 2, 0);
  lib.step(0.015);
  EXPECT_EQ(Cause(), 2);
}

// A ramp of speed a: the difference over a window w is late by w / 2, so it shows a (t - w / 2).
TEST_F(DhdTest, VelocityComesFromAWindow) {
  lib.set_option("resolution", "0");
  lib.set_option("viscosity", "0");
  lib.set_option("dry", "0");
  Open("omega.3", true);
  set_force(0, 0.22, 0, -1);
  const auto run = [this] {
    for (int i = 0; i < 50; ++i) {
      lib.step(0.001);
      position(&x, &y, &z, -1);
    }
    EXPECT_EQ(velocity(&x, &y, &z, -1), 1);
    return y;
  };
  EXPECT_NEAR(run(), 0.050 - 0.010, 1e-6);
  configure_velocity(4, 0, -1);
  EXPECT_NEAR(run(), 0.100 - 0.002, 1e-6);
}

TEST_F(DhdTest, ASigmaHasAWristAndAGripperAndAnOmega3HasNone) {
  double R[3][3];
  Open("omega.3", false);
  EXPECT_EQ(frame(R, -1), -1);
  EXPECT_EQ(last_error(), 6);
  EXPECT_EQ(gap(&x, -1), -1);
  close(-1);
  Open("sigma.7", true);
  lib.turn(0, 0, M_PI / 2);
  EXPECT_EQ(frame(R, -1), 0);
  EXPECT_NEAR(R[1][0], 1, 1e-12) << "x turns to y";
  lib.set_option("gripper", "0.5");
  EXPECT_EQ(gap(&x, -1), 0);
  EXPECT_NEAR(x, 0.12 * std::sin(0.25), 1e-12);
  EXPECT_EQ(set_all(1, 2, 3, 0.1, 0.2, 0.3, 4, -1), 0);
  FakeForce log;
  ASSERT_EQ(lib.force_log(&log, 1), 1);
  EXPECT_EQ(log.asked[5], 0.3);
  EXPECT_EQ(log.asked[6], 4);
}

TEST_F(DhdTest, APulledPlugFailsEveryCallUntilTheDeviceIsOpenedAgain) {
  Open("omega.3", true);
  set_force(1, 0, 0, -1);
  lib.unplug();
  EXPECT_EQ(position(&x, &y, &z, -1), -1);
  EXPECT_EQ(last_error(), 2);
  EXPECT_EQ(set_force(1, 0, 0, -1), -1);
  EXPECT_EQ(Cause(), 5);
  EXPECT_EQ(Made(), 0);
  lib.replug();
  EXPECT_EQ(position(&x, &y, &z, -1), -1);
  close(-1);
  EXPECT_EQ(position(&x, &y, &z, -1), -1) << "closed";
  EXPECT_EQ(open(), 0);
  EXPECT_EQ(position(&x, &y, &z, -1), 0);
  EXPECT_EQ(position(&x, &y, &z, 3), -1) << "no such device";
}

TEST_F(DhdTest, AFrozenDeviceRepeatsItsAnswersAndKeepsItsForce) {
  Open("omega.3", true);
  set_force(1, 0, 0, -1);
  position(&x, &y, &z, -1);
  lib.freeze(1);
  lib.place(0.03, 0, 0);
  lib.step(0.01);
  EXPECT_EQ(position(&x, &y, &z, -1), 1);
  EXPECT_EQ(x, 0);
  set_force(0, 0, 0, -1);
  EXPECT_EQ(Made(), 1);
}

// One failure of one call among many that succeed, and a read without news beside it: a sum of the
// codes would be zero.
TEST_F(DhdTest, AnInjectedErrorFailsTheCallItIsFor) {
  Open("omega.3", true);
  lib.set_error("dhdGetLinearVelocity", -1, 1);
  EXPECT_EQ(position(&x, &y, &z, -1), 0);
  EXPECT_EQ(position(&x, &y, &z, -1) + velocity(&x, &y, &z, -1), 0);
  EXPECT_GE(velocity(&x, &y, &z, -1), 0);
  EXPECT_EQ(lib.calls("dhdGetLinearVelocity"), 2);
}

// The hand's grip is a spring of 300 N/m: at rest the handle is where the hand is; a force f moves
// it by f / k.
TEST_F(DhdTest, TheOperatorsHandFollowsItsScriptAndYields) {
  lib.set_option("dry", "0");
  Open("omega.3", true);
  const FakeKnot way[] = {{0, 0, 0, 0}, {0.5, 0, 0.03, 0}};
  lib.follow(way, 2, 0);
  for (int i = 0; i < 30; ++i) {
    set_force(0, 0.3, 0, -1);
    lib.step(0.05);
  }
  double p[3], v[3];
  lib.get_handle(p, v);
  EXPECT_NEAR(p[1], 0.03 + 0.3 / 300, 1e-6);
}

// A program gets its fake in this state, and a test outside of it speaks to the socket.
TEST(DhdEnvironmentTest, CommandsAndASocketControlAProgram) {
  const std::string path = testing::TempDir() + "/dhd_test.sock";
  setenv("PALPATE_FAKE_DHD_COMMANDS", "clock 0;set model falcon;place 0.01 0 0", 1);
  setenv("PALPATE_FAKE_DHD_CONTROL", path.c_str(), 1);
  void* program = dlopen(BinaryPath("/fakes/dhd/libdhd.so.3").c_str(), RTLD_NOW | RTLD_GLOBAL);
  unsetenv("PALPATE_FAKE_DHD_COMMANDS");
  unsetenv("PALPATE_FAKE_DHD_CONTROL");
  ASSERT_TRUE(program) << dlerror();
  const int line = socket(AF_UNIX, SOCK_STREAM, 0);
  sockaddr_un address{};
  address.sun_family = AF_UNIX;
  std::strncpy(address.sun_path, path.c_str(), sizeof address.sun_path - 1);
  ASSERT_EQ(connect(line, reinterpret_cast<sockaddr*>(&address), sizeof address), 0);
  char reply[100] = {};
  send(line, "handle\n", 7, 0);
  recv(line, reply, sizeof reply - 1, 0);
  EXPECT_STREQ(reply, "0.01 0 0 0 0 0\n");
  dlclose(program);
  EXPECT_EQ(recv(line, reply, sizeof reply, 0), 0) << "ends with the library";
  close(line);
}

TEST(DhdVariantsTest, LackWhatTheySay) {
  const Library missing("dhd-missing", "libdhd.so"), old("dhd-old", "libdhd.so");
  EXPECT_FALSE(missing.Find<void()>("dhdSetForce"));
  EXPECT_FALSE(old.Find<void()>("dhdSetForceAndTorqueAndGripperForce"));
  int version[4];
  old.Find<void(int*, int*, int*, int*)>("dhdGetSDKVersion")(version, version + 1, version + 2,
                                                             version + 3);
  EXPECT_EQ(version[1], 2);
  old.Find<int()>("dhdOpen")();
  int status[17];
  status[13] = 4711;
  EXPECT_EQ(old.Find<int(int*, char)>("dhdGetStatus")(status, 0), 0);
  EXPECT_EQ(status[13], 4711) << "13 numbers";
}

}  // namespace
}  // namespace palpate::fakes
