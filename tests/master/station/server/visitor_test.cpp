#include <gtest/gtest.h>

#include "master/station/server/page_access.h"

namespace palpate {
namespace {

TEST(VisitorTest, ThisMachineByAnyOfItsNames) {
  for (const char* host :
       {"127.0.0.1:8080", "localhost", "localhost:1", "[::1]:443", "127.8.8.8:80"}) {
    EXPECT_EQ(RefusalOfHost(host), "") << host;
  }
}

TEST(VisitorTest, NoOtherName) {
  for (const char* host :
       {"", ":", "example.com", "example.com:80", "127.0.0.1.example.com",
        "localhost.example.com:80", "0.0.0.0:80", "[fe80::1]:80", "127.0.0.1:80:80"}) {
    EXPECT_NE(RefusalOfHost(host), "") << host;
  }
}

TEST(VisitorTest, OnlyThePageItself) {
  EXPECT_EQ(RefusalOfOrigin("", "localhost:1", "http://"), "");
  EXPECT_EQ(RefusalOfOrigin("http://localhost:1", "localhost:1", "http://"), "");
  EXPECT_EQ(RefusalOfOrigin("https://station:1", "station:1", "https://"), "");
  EXPECT_NE(RefusalOfOrigin("http://station:1", "station:1", "https://"), "");
  for (const char* origin : {"http://localhost:2", "https://localhost:1", "null",
                             "http://localhost:1/", "http://evil.example"}) {
    EXPECT_NE(RefusalOfOrigin(origin, "localhost:1", "http://"), "") << origin;
  }
}

}  // namespace
}  // namespace palpate
