#include <cstdint>
#include <string>

#include <gtest/gtest.h>

#include "tests/master/device/fakes/fake_library.h"

namespace palpate::fakes {
namespace {

class SdlTest : public testing::Test {
 protected:
  Library lib{"sdl", "libSDL2.so"};
  template <class F>
  F* At(const char* name) {
    return lib.Find<F>(name);
  }
  int (*init)(std::uint32_t) = At<int(std::uint32_t)>("SDL_Init");
  void (*pump)() = At<void()>("SDL_PumpEvents");
  int (*count)() = At<int()>("SDL_NumJoysticks");
  int (*is_controller)(int) = At<int(int)>("SDL_IsGameController");
  void* (*open)(int) = At<void*(int)>("SDL_GameControllerOpen");
  int (*attached)(void*) = At<int(void*)>("SDL_GameControllerGetAttached");
  std::int16_t (*axis)(void*, int) = At<std::int16_t(void*, int)>("SDL_GameControllerGetAxis");
  unsigned char (*button)(void*,
                          int) = At<unsigned char(void*, int)>("SDL_GameControllerGetButton");
  int (*rumble)(void*, std::uint16_t, std::uint16_t, std::uint32_t) =
      At<int(void*, std::uint16_t, std::uint16_t, std::uint32_t)>("SDL_GameControllerRumble");
  int (*has_rumble)(void*) = At<int(void*)>("SDL_GameControllerHasRumble");

  void SetUp() override { lib.set_clock(0); }
  void* Open(const char* kind) {
    lib.set_option("pad", kind);
    EXPECT_EQ(init(0x2000), 0);
    return open(0);
  }
  // The strong motor's part of its full strength.
  double Rumbles() {
    double f[3];
    lib.last_force(f);
    return f[0];
  }
};

TEST_F(SdlTest, SticksAndButtonsChangeWhenEventsArePumped) {
  EXPECT_EQ(count(), 0) << "before SDL_Init";
  void* pad = Open("wired");
  ASSERT_TRUE(pad);
  EXPECT_EQ(count(), 1);
  EXPECT_EQ(axis(pad, 0), 512) << "a stick at rest is not at zero";
  lib.set_option("drift_x", "0");
  const FakeKnot pushed[] = {{0, 0.005, 0.010, 0}};
  lib.follow(pushed, 1, 0);
  lib.press(9, 1, 0);
  lib.step(0.01);
  EXPECT_EQ(axis(pad, 0), 0);
  pump();
  EXPECT_EQ(axis(pad, 0), 16384);
  EXPECT_EQ(axis(pad, 1), -32768) << "up is negative";
  EXPECT_EQ(button(pad, 9), 1);
}

TEST_F(SdlTest, ARumbleEndsAfterItsTime) {
  void* pad = Open("wired");
  EXPECT_EQ(has_rumble(pad), 1);
  EXPECT_EQ(rumble(pad, 65535, 0, 100), 0);
  lib.step(0.099);
  EXPECT_EQ(Rumbles(), 1);
  lib.step(0.002);
  EXPECT_EQ(Rumbles(), 0);
}

TEST_F(SdlTest, BluetoothTakesOneCommandIn50Milliseconds) {
  void* pad = Open("xbox");
  rumble(pad, 65535, 0, 1000);
  lib.step(0.049);
  EXPECT_EQ(rumble(pad, 0, 0, 0), 0) << "lost, and nothing tells";
  EXPECT_EQ(Rumbles(), 1);
  lib.step(0.001);
  rumble(pad, 0, 0, 0);
  EXPECT_EQ(Rumbles(), 0);
}

TEST_F(SdlTest, OtherPadsStopBeforeTheirTime) {
  void* pad = Open("ds4");
  rumble(pad, 65535, 0, 20000);
  lib.step(4.99);
  EXPECT_EQ(Rumbles(), 1);
  lib.step(0.02);
  EXPECT_EQ(Rumbles(), 0);
  lib.set_option("pad", "pulse");
  rumble(pad, 65535, 0, 1000);
  lib.step(0.051);
  EXPECT_EQ(Rumbles(), 0);
}

TEST_F(SdlTest, APulledPlugReadsAsRestAndNeedsAnotherOpening) {
  void* pad = Open("wired");
  const FakeKnot pushed[] = {{0, 0.005, 0, 0}};
  lib.follow(pushed, 1, 0);
  lib.unplug();
  EXPECT_EQ(attached(pad), 1) << "until events are pumped";
  EXPECT_EQ(rumble(pad, 1, 1, 100), -1);
  pump();
  EXPECT_EQ(attached(pad), 0);
  EXPECT_EQ(axis(pad, 0), 0);
  EXPECT_EQ(count(), 0);
  lib.replug();
  pump();
  EXPECT_EQ(count(), 1);
  EXPECT_EQ(attached(pad), 0);
  EXPECT_EQ(attached(open(0)), 1);
}

TEST_F(SdlTest, SomeControllersHaveNoRumbleAndSomeJoysticksNoMapping) {
  lib.set_option("rumble", "0");
  void* pad = Open("wired");
  EXPECT_EQ(has_rumble(pad), 0);
  EXPECT_EQ(rumble(pad, 1, 1, 100), -1);
  lib.set_option("controller", "0");
  EXPECT_EQ(count(), 1);
  EXPECT_EQ(is_controller(0), 0);
  EXPECT_EQ(open(0), nullptr);
}

TEST_F(SdlTest, AFrozenControllerRepeatsItsState) {
  void* pad = Open("wired");
  lib.freeze(1);
  const FakeKnot pushed[] = {{0, 0.005, 0, 0}};
  lib.follow(pushed, 1, 0);
  lib.step(0.01);
  pump();
  EXPECT_EQ(axis(pad, 0), 512);
  lib.freeze(0);
  pump();
  EXPECT_NEAR(axis(pad, 0), 16384 + 512, 1);
}

TEST(SdlVariantsTest, LackWhatTheySay) {
  const Library missing("sdl-missing", "libSDL2.so"), old("sdl-old", "libSDL2.so");
  EXPECT_FALSE(missing.Find<void()>("SDL_GameControllerGetAttached"));
  EXPECT_FALSE(old.Find<void()>("SDL_GameControllerRumble"));
  unsigned char version[3];
  old.Find<void(unsigned char*)>("SDL_GetVersion")(version);
  EXPECT_EQ(version[2], 5);
}

// What programs use instead of functions: lines of text.
TEST_F(SdlTest, LinesOfTextDoTheSameAsFunctions) {
  char reply[200];
  EXPECT_EQ(lib.command("set pad wired", reply, 200), 0);
  EXPECT_STREQ(reply, "ok");
  EXPECT_EQ(lib.command("place 0.001 0 0", reply, 200), 0);
  EXPECT_EQ(lib.command("handle", reply, 200), 0);
  EXPECT_EQ(std::string(reply), "0.001 0 0 0 0 0");
  EXPECT_EQ(lib.command("set mass heavy", reply, 200), -1);
  EXPECT_EQ(lib.command("dance", reply, 200), -1);
  EXPECT_STREQ(reply, "error: not understood: dance");
}

}  // namespace
}  // namespace palpate::fakes
