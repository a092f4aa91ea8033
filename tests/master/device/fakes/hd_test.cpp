#include <atomic>
#include <chrono>
#include <cmath>
#include <thread>

#include <gtest/gtest.h>

#include "tests/master/device/fakes/fake_library.h"
#include "tests/support/allocation_count.h"

namespace palpate::fakes {
namespace {

constexpr unsigned kInvalid = 0xFFFFFFFF;
struct ErrorInfo {
  unsigned code;
  int internal;
  unsigned device;
};

class HdTest : public testing::Test {
 protected:
  using Callback = unsigned (*)(void*);
  Library lib{"hd", "libHD.so"};
  template <class F>
  F* At(const char* name) {
    return lib.Find<F>(name);
  }
  unsigned (*init)(const char*) = At<unsigned(const char*)>("hdInitDevice");
  void (*disable_device)(unsigned) = At<void(unsigned)>("hdDisableDevice");
  void (*begin)(unsigned) = At<void(unsigned)>("hdBeginFrame");
  void (*end)(unsigned) = At<void(unsigned)>("hdEndFrame");
  ErrorInfo (*error)() = At<ErrorInfo()>("hdGetError");
  void (*enable)(unsigned) = At<void(unsigned)>("hdEnable");
  void (*disable)(unsigned) = At<void(unsigned)>("hdDisable");
  void (*get)(unsigned, double*) = At<void(unsigned, double*)>("hdGetDoublev");
  void (*get_integer)(unsigned, int*) = At<void(unsigned, int*)>("hdGetIntegerv");
  void (*set)(unsigned, const double*) = At<void(unsigned, const double*)>("hdSetDoublev");
  unsigned (*calibration)() = At<unsigned()>("hdCheckCalibration");
  void (*calibrate)(unsigned) = At<void(unsigned)>("hdUpdateCalibration");
  void (*start)() = At<void()>("hdStartScheduler");
  void (*stop)() = At<void()>("hdStopScheduler");
  unsigned long (*schedule)(Callback, void*, unsigned short) =
      At<unsigned long(Callback, void*, unsigned short)>("hdScheduleAsynchronous");
  void (*schedule_and_wait)(Callback, void*, unsigned short) =
      At<void(Callback, void*, unsigned short)>("hdScheduleSynchronous");
  void (*unschedule)(unsigned long) = At<void(unsigned long)>("hdUnschedule");

  double force[3] = {0, 0, 0};  // what the callback below gives [N]
  double seen[3] = {0, 0, 0};   // where it found the handle [mm]
  std::atomic<int> ticks = 0;

  static unsigned Servo(void* data) {
    auto& test = *static_cast<HdTest*>(data);
    test.begin(0);
    test.get(0x2050, test.seen);
    test.set(0x2700, test.force);
    test.end(0);
    ++test.ticks;
    return 1;
  }
  // A device under an injected clock, with the servo callback scheduled and forces at once.
  void Run() {
    lib.set_clock(0);
    ASSERT_EQ(init(nullptr), 0u);
    enable(0x4000);
    enable(0x4001);
    disable(0x4002);
    schedule(Servo, this, 30000);
    start();
    ASSERT_EQ(error().code, 0u);
  }
  double Moved() {
    double p[3], v[3];
    lib.get_handle(p, v);
    return p[0];
  }
};

// Reference: Newton. Without friction the handle follows f t^2 / 2 m; the first tick, at time zero,
// already gives the force.
TEST_F(HdTest, AConstantForceMovesTheHandleAsItsMassSays) {
  lib.set_option("mass", "0.1");
  lib.set_option("viscosity", "0");
  lib.set_option("dry", "0");
  Run();
  force[0] = 0.5;
  lib.step(0.1);
  EXPECT_NEAR(Moved(), 0.5 * 5 * 0.1 * 0.1, 1e-6);
  EXPECT_EQ(ticks, 101);
  EXPECT_NEAR(seen[0], 1e3 * Moved(), 0.0275 + 1e-9) << "millimetres, within half an encoder step";
}

// Reference: a force below dry friction moves nothing, and viscous friction leads to f / b, which
// is reached within exp(-7) after seven times m / b.
TEST_F(HdTest, FrictionHoldsTheHandleAndLimitsItsSpeed) {
  lib.set_option("mass", "0.01");
  lib.set_option("viscosity", "10");
  lib.set_option("dry", "0.2");
  Run();
  force[0] = 0.19;
  lib.step(0.1);
  EXPECT_EQ(Moved(), 0);
  force[0] = 0.4;
  lib.step(0.05);
  double p[3], v[3];
  lib.get_handle(p, v);
  EXPECT_NEAR(v[0], (0.4 - 0.2) / 10, 1e-4);
}

TEST_F(HdTest, NamesAndTheFirstCallDecideWhetherThereIsADevice) {
  lib.set_option("null", "0");
  EXPECT_EQ(init(nullptr), kInvalid);
  EXPECT_EQ(init("Left"), kInvalid);
  EXPECT_EQ(init("Default Device"), 0u);
  EXPECT_EQ(init("Default Device"), kInvalid) << "twice";
  for (const unsigned code : {0x300u, 0x300u, 0x301u, 0u}) EXPECT_EQ(error().code, code);
  lib.reset();
  lib.set_option("init_failures", "1");
  EXPECT_EQ(init(nullptr), kInvalid);
  EXPECT_EQ(init(nullptr), 0u);
  lib.reset();
  lib.set_option("handle", "70000");
  EXPECT_EQ(init(nullptr), 70000u);
  begin(70000);
  EXPECT_EQ(error().code, 0x104u) << "a handle above 1024 is garbage";
}

// The transform's columns follow one another, millimetres in the last; a quarter turn about z turns
// x to y.
TEST_F(HdTest, AFrameKeepsOneStateAndForcesNeedIt) {
  Run();
  double transform[16], later[3];
  lib.place(0.01, 0, 0);
  lib.turn(0, 0, M_PI / 2);
  begin(0);
  get(0x2052, transform);
  EXPECT_NEAR(transform[12], 10, 0.03);
  EXPECT_NEAR(transform[1], 1, 1e-12);
  lib.place(0.02, 0, 0);
  get(0x2050, later);
  EXPECT_EQ(later[0], transform[12]);
  begin(0);
  EXPECT_EQ(error().code, 0x400u) << "a frame within a frame";
  end(0);
  set(0x2700, force);
  EXPECT_EQ(error().code, 0x402u) << "a force outside of a frame";
  end(0);
  EXPECT_EQ(error().code, 0x401u);
  int dof = 0;
  get(0x2553, later);
  EXPECT_EQ(error().code, 0x103u) << "a count read as doubles";
  get_integer(0x2554, &dof);
  EXPECT_EQ(dof, 3);
}

TEST_F(HdTest, TooMuchForceIsClampedOrEndsWithAnError) {
  Run();
  force[1] = 50;
  lib.step(0.001);
  double made[3];
  EXPECT_EQ(lib.last_force(made), 1);
  EXPECT_DOUBLE_EQ(made[1], 3.3);
  disable(0x4001);
  lib.step(0.001);
  lib.last_force(made);
  EXPECT_EQ(made[1], 0);
  EXPECT_EQ(error().code, 0x201u);
  force[1] = NAN;
  lib.step(0.001);
  EXPECT_EQ(error().code, 0x204u);
  FakeForce log[4];
  ASSERT_EQ(lib.force_log(log, 4), 4);
  EXPECT_TRUE(std::isnan(log[3].asked[1]));
  EXPECT_EQ(log[3].made[1], 0);
}

TEST_F(HdTest, ForcesRampUpAfterTheyAreEnabled) {
  Run();
  enable(0x4002);
  force[0] = 2;
  lib.step(0.01);
  double made[3];
  lib.last_force(made);
  EXPECT_NEAR(made[0], 1, 1e-9) << "100 N/s";
  lib.step(0.02);
  lib.last_force(made);
  EXPECT_EQ(made[0], 2);
}

// Twice the continuous force heats fourfold: the limit is reached after ln(4/3) of the time
// constant.
TEST_F(HdTest, MotorsThatStayAboveTheContinuousForceGetWarm) {
  lib.set_option("heating", "1");
  Run();
  force[2] = 2 * 0.88;
  lib.step(0.95 * std::log(4.0 / 3.0));
  EXPECT_EQ(error().code, 0u);
  lib.step(0.1 * std::log(4.0 / 3.0));
  EXPECT_EQ(error().code, 0x200u);
  double made[3];
  EXPECT_EQ(lib.last_force(made), 0);
  double temperature[6];
  get(0x2605, temperature);
  EXPECT_NEAR(temperature[0], 1, 0.05);
}

TEST_F(HdTest, TheInkwellCalibratesAndBeforeThatThePositionIsWrong) {
  lib.set_clock(0);
  lib.set_option("calibration", "manual");
  ASSERT_EQ(init(nullptr), 0u);
  EXPECT_EQ(calibration(), 0x5002u);
  double position[3];
  get(0x2050, position);
  EXPECT_NEAR(position[0], 25, 1e-9) << "lost counts";
  calibrate(4);
  EXPECT_EQ(error().code, 0x102u);
  int switched = 1;
  lib.set_option("parked", "1");
  get_integer(0x2002, &switched);
  EXPECT_EQ(switched, 0);
  EXPECT_EQ(calibration(), 0x5001u);
  calibrate(4);
  EXPECT_EQ(calibration(), 0x5000u);
  begin(0);
  get(0x2050, position);
  EXPECT_EQ(position[0], 0);
}

TEST_F(HdTest, APulledPlugGivesErrorsUntilTheDeviceIsInitiatedAgain) {
  Run();
  force[0] = 1;
  lib.step(0.002);
  lib.unplug();
  lib.step(0.001);
  double made[3];
  EXPECT_EQ(lib.last_force(made), 0);
  EXPECT_EQ(error().code, 0x302u);
  EXPECT_EQ(error().code, 0x302u) << "once for each end of the frame";
  lib.replug();
  lib.step(0.001);
  EXPECT_EQ(lib.last_force(made), 0);
  stop();
  disable_device(0);
  while (error().code) {
  }
  EXPECT_EQ(init(nullptr), 0u);
}

TEST_F(HdTest, AFrozenDeviceRepeatsItsAnswersAndAStalledOneIsSilent) {
  Run();
  lib.place(0.01, 0, 0);
  lib.step(0.001);
  lib.freeze(1);
  lib.place(0.03, 0, 0);
  lib.step(0.01);
  EXPECT_NEAR(seen[0], 10, 0.03);
  EXPECT_EQ(error().code, 0u);
  const int before = ticks;
  lib.freeze(2);
  lib.step(0.01);
  EXPECT_EQ(ticks, before);
  lib.freeze(0);
  lib.step(0.001);
  EXPECT_NEAR(seen[0], 30, 0.03);
}

// The order is that of priority, and a callback that returns 0 runs once.
TEST_F(HdTest, CallbacksRunByPriorityOnTheOwnThread) {
  ASSERT_EQ(init(nullptr), 0u);
  schedule_and_wait([](void*) { return 0u; }, nullptr, 0);
  EXPECT_EQ(error().code, 0x102u) << "nobody runs it";
  const unsigned long id = schedule(Servo, this, 100);
  start();
  std::pair<std::thread::id, int> ran{};
  const auto once = [](void* data) {
    auto& found = *static_cast<std::pair<std::thread::id, int>*>(data);
    found.first = std::this_thread::get_id();
    return ++found.second < 3 ? 1u : 0u;
  };
  schedule_and_wait(once, &ran, 200);
  EXPECT_EQ(ran.second, 3);
  EXPECT_NE(ran.first, std::this_thread::get_id());
  while (ticks < 10) std::this_thread::sleep_for(std::chrono::milliseconds(1));
  unschedule(id);
  const int after = ticks;
  std::this_thread::sleep_for(std::chrono::milliseconds(5));
  EXPECT_EQ(ticks, after);
  stop();
  EXPECT_EQ(error().code, 0u);
}

// Drivers' tests count allocations in the loop: there shall be none of the fake's.
TEST_F(HdTest, TheLoopAllocatesNoMemory) {
  Run();
  lib.step(0.01);
  const long before = AllocationCount();
  lib.step(0.1);
  EXPECT_EQ(AllocationCount(), before);
}

TEST_F(HdTest, AnInjectedErrorComesWithTheCallItIsFor) {
  Run();
  lib.set_error("hdEndFrame", 0x300, 2);
  lib.step(0.002);
  EXPECT_EQ(error().code, 0x300u);
  EXPECT_EQ(error().code, 0x300u) << "one call gives one error";
  EXPECT_EQ(lib.calls("hdEndFrame"), 3);
}

TEST(HdVariantsTest, LackWhatTheySay) {
  const Library missing("hd-missing", "libHD.so"), old("hd-old", "libHD.so");
  EXPECT_FALSE(missing.Find<void()>("hdGetError"));
  EXPECT_TRUE(missing.Find<void()>("hdBeginFrame"));
  EXPECT_FALSE(old.Find<void()>("hdSetSchedulerRate"));
  EXPECT_STREQ(old.Find<const char*(unsigned)>("hdGetString")(0x2502), "1.02.14");
}

}  // namespace
}  // namespace palpate::fakes
