#include "master/station/pointer_control_lock.h"

#include <gtest/gtest.h>

namespace palpate {
namespace {

constexpr std::uint64_t kFirst = 1, kSecond = 2;

Time LockTime(int ms) {
  return Time{std::chrono::hours(1)} + std::chrono::milliseconds(ms);
}

TEST(PointerControlLockTest, TheFirstEngagedPageHasControlUntilItDisengages) {
  PointerControlLock lead;
  EXPECT_TRUE(lead.Hears(kFirst, true, LockTime(0), Pointer::kMinSilence));
  EXPECT_FALSE(lead.Hears(kSecond, true, LockTime(10), Pointer::kMinSilence));
  EXPECT_FALSE(lead.Hears(kSecond, false, LockTime(15), Pointer::kMinSilence))
      << "what another page lets go is not the hand";
  EXPECT_TRUE(lead.Hears(kFirst, true, LockTime(20), Pointer::kMinSilence));
  EXPECT_TRUE(lead.Hears(kFirst, false, LockTime(30), Pointer::kMinSilence));
  EXPECT_TRUE(lead.Hears(kSecond, true, LockTime(40), Pointer::kMinSilence));
}

TEST(PointerControlLockTest, APageThatEngagedDuringAnothersControlMustReleaseFirst) {
  PointerControlLock lead;
  EXPECT_TRUE(lead.Hears(kFirst, true, LockTime(0), Pointer::kMinSilence));
  EXPECT_FALSE(lead.Hears(kSecond, true, LockTime(10), Pointer::kMinSilence));
  EXPECT_TRUE(lead.Hears(kFirst, false, LockTime(20), Pointer::kMinSilence));
  EXPECT_FALSE(lead.Hears(kSecond, true, LockTime(30), Pointer::kMinSilence));
  EXPECT_FALSE(lead.Hears(kSecond, true, LockTime(1000), Pointer::kMinSilence));
  EXPECT_TRUE(lead.Hears(kSecond, false, LockTime(1010), Pointer::kMinSilence));
  EXPECT_TRUE(lead.Hears(kSecond, true, LockTime(1020), Pointer::kMinSilence));
}

// A suspended laptop keeps its connection but sends nothing.
TEST(PointerControlLockTest, ASilentPageLosesControlToAnotherPage) {
  PointerControlLock lead;
  EXPECT_TRUE(lead.Hears(kFirst, true, LockTime(0), Pointer::kMinSilence));
  EXPECT_FALSE(lead.Hears(kSecond, false, LockTime(300), Pointer::kMinSilence))
      << "nobody took it over";
  EXPECT_TRUE(lead.Hears(kSecond, true, LockTime(310), Pointer::kMinSilence));
  EXPECT_FALSE(lead.Hears(kFirst, true, LockTime(320), Pointer::kMinSilence));
  EXPECT_TRUE(lead.Hears(kSecond, true, LockTime(330), Pointer::kMinSilence));
  EXPECT_FALSE(lead.Leaves(kFirst));
  EXPECT_TRUE(lead.Leaves(kSecond));
  EXPECT_TRUE(lead.Hears(kFirst, true, LockTime(340), Pointer::kMinSilence));
}

// The page of a busy browser may be silent for as long as the pointer tolerates.
TEST(PointerControlLockTest, ALatePageKeepsControlForItsOwnLimit) {
  PointerControlLock lead;
  EXPECT_TRUE(lead.Hears(kFirst, true, LockTime(0), 0.6));
  EXPECT_FALSE(lead.Hears(kSecond, true, LockTime(600), Pointer::kMinSilence));
  EXPECT_FALSE(lead.Hears(kSecond, false, LockTime(605), Pointer::kMinSilence));
  EXPECT_TRUE(lead.Hears(kSecond, true, LockTime(610), Pointer::kMinSilence));
}

}  // namespace
}  // namespace palpate
