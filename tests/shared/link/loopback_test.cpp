#include "shared/link/loopback.h"

#include <stdexcept>

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include "tests/support/thrown.h"

namespace palpate {
namespace {

TEST(LoopbackTest, AddressesComeApartAndTogetherAgain) {
  for (const char* address : {"127.0.0.1:0", "localhost:50051", "[::1]:0", "[fe80::1]:65535",
                              "[fe80::1%eth0]:1", "[fe80::1%2]:1", "slave.example:1"}) {
    EXPECT_EQ(ToString(ParseEndpoint(address)), address);
  }
  EXPECT_EQ(ParseEndpoint("[::1]:7").host, "::1");
  EXPECT_EQ(ParseEndpoint("[::1]:7").port, 7);
}

TEST(LoopbackTest, WhatIsNoAddressIsRefusedAndNamed) {
  for (const char* address : {"", "localhost", ":50051", "localhost:port", "localhost:-1",
                              "::1:50051", "[]:1", "[fe80::1%a b]:1", "[::1:1", "local host:1"}) {
    EXPECT_THAT(
        Thrown<std::invalid_argument>([&] { ParseEndpoint(address); }),
        testing::AllOf(testing::StartsWith(address), testing::HasSubstr("expected HOST:PORT")));
  }
}

TEST(LoopbackTest, OnlyWhatStaysOnThisMachineIsLoopback) {
  for (const char* host :
       {"127.0.0.1", "127.255.0.9", "::1", "::ffff:127.0.0.1", "localhost", "LocalHost"}) {
    EXPECT_TRUE(IsLoopback(host)) << host;
  }
  for (const char* host : {"0.0.0.0", "::", "128.0.0.1", "10.0.0.1", "::ffff:10.0.0.1", "fe80::1",
                           "localhost.example", "127.0.0.1.example", ""}) {
    EXPECT_FALSE(IsLoopback(host)) << host;
  }
}

TEST(LoopbackTest, PlainTextLeavesThisMachineOnlyOnRequest) {
  const Endpoint everywhere{"0.0.0.0", 1};
  EXPECT_THROW(RequireLoopbackUnless(false, everywhere), std::invalid_argument);
  EXPECT_NO_THROW(RequireLoopbackUnless(true, everywhere));
  EXPECT_NO_THROW(RequireLoopbackUnless(false, {"127.0.0.1", 1}));
}

}  // namespace
}  // namespace palpate
