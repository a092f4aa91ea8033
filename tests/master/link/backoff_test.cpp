#include <gtest/gtest.h>

#include "master/link/channel.h"

namespace palpate {
namespace {

using std::chrono::milliseconds;

TEST(BackoffTest, DoublesUpToTheLongestAndStartsAnewAfterSuccess) {
  Backoff backoff(milliseconds(50), milliseconds(500));
  for (const int expected : {50, 100, 200, 400, 500, 500}) {
    EXPECT_EQ(backoff.Next(), milliseconds(expected));
  }
  backoff.Reset();
  EXPECT_EQ(backoff.Next(), milliseconds(50));
}

}  // namespace
}  // namespace palpate
