// Tests the server with hostile clients: other hosts and origins, invalid data, floods.
#include <memory>
#include <optional>
#include <string>
#include <thread>
#include <utility>
#include <vector>

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include "master/station/server/page_command.h"
#include "master/station/server/page_server.h"
#include "tests/master/station/server/page_client.h"
#include "tests/support/eventually.h"

namespace palpate {
namespace {

using testing::HasSubstr;
using testing::StartsWith;

class HostileVisitorTest : public testing::Test {
 protected:
  [[nodiscard]] std::string Host() const { return ToString(server_.endpoint()); }
  std::string Query(const std::string& request) {
    PageClient client(server_.endpoint());
    client.Send(request);
    return client.ReadAll();
  }
  // Returns the reason with which a page that sends `frames` is closed; empty: the connection ended
  // without one.
  std::string ClosedBecause(const std::string& frames) {
    PageClient page(server_.endpoint());
    page.Upgrade(Host(), "");
    page.Send(frames);
    const auto close = page.ReadFrame(kClose);
    return close ? close->reason() : "";
  }
  // Checks that the server still serves.
  void ExpectSound() {
    PageClient page(server_.endpoint());
    EXPECT_THAT(page.Upgrade(Host(), ""), HasSubstr("101"));
    page.SendText(R"({"do":"ping","at":1})");
    const auto answer = page.ReadFrame(kText);
    ASSERT_TRUE(answer);
    EXPECT_EQ(answer->payload, "pong");
  }

  NoticeBoard board_;
  PageServer server_{{"127.0.0.1", 0},
                     &board_,
                     {[](std::uint64_t /*page*/, std::string_view message) -> std::string {
                        ReadPageCommand(message);
                        return "pong";
                      },
                      [](std::uint64_t /*page*/) {}}};
};

TEST_F(HostileVisitorTest, ANameThatWasReboundIsRefused) {
  for (const char* host : {"evil.example", "evil.example:80", "127.0.0.1.evil.example:1",
                           "10.0.0.7", "", "[::2]:80"}) {
    EXPECT_THAT(Query("GET / HTTP/1.1\r\nHost: " + std::string(host) + "\r\n\r\n"),
                StartsWith("HTTP/1.1 421"))
        << host;
    PageClient page(server_.endpoint());
    EXPECT_THAT(page.Upgrade(host, ""), HasSubstr("421")) << host;
  }
}

TEST_F(HostileVisitorTest, AnotherPageCannotOperate) {
  for (const std::string& origin :
       {std::string("http://evil.example"), "https://" + Host(), std::string("null"),
        std::string("http://127.0.0.1:1"), "http://" + Host() + ".evil.example"}) {
    PageClient page(server_.endpoint());
    EXPECT_THAT(page.Upgrade(Host(), origin), HasSubstr("403")) << origin;
  }
  ExpectSound();
}

TEST_F(HostileVisitorTest, ThroughATunnelThePortIsAnother) {
  PageClient page(server_.endpoint());
  EXPECT_THAT(page.Upgrade("localhost:8080", "http://localhost:8080"), HasSubstr("101"));
}

TEST_F(HostileVisitorTest, BadRequestsAreAnsweredAndForgotten) {
  EXPECT_THAT(Query("nonsense\r\n\r\n"), StartsWith("HTTP/1.1 400"));
  EXPECT_THAT(
      Query("GET / HTTP/1.1\r\nHost: localhost\r\nX: " + std::string(20000, 'x') + "\r\n\r\n"),
      StartsWith("HTTP/1.1 400"));
  EXPECT_THAT(Query("DELETE / HTTP/1.1\r\nHost: localhost\r\n\r\n"), StartsWith("HTTP/1.1 405"));
  Query("POST / HTTP/1.1\r\nHost: localhost\r\nContent-Length: 1000000000\r\n\r\nxxx");
  Query(std::string(100, '\0'));
  ExpectSound();
}

TEST_F(HostileVisitorTest, AnInvalidCommandClosesThePageWithTheReason) {
  for (const char* message :
       {"", "{", "[]", "1", R"({"do":"fly"})", R"({"do":5})", R"({"do":"ping","at":1e999})",
        R"({"do":"pointer","at":1,"p_M":[0,0,1e9],"engaged":true})"}) {
    PageClient page(server_.endpoint());
    page.Upgrade(Host(), "");
    page.SendText(message);
    const auto close = page.ReadFrame(kClose);
    ASSERT_TRUE(close) << message;
    EXPECT_THAT(close->reason(), HasSubstr("not understood")) << message;
  }
  ExpectSound();
}

TEST_F(HostileVisitorTest, BrokenFramesEndTheLine) {
  ClosedBecause("\x81\x05hello");  // not masked
  // Reserved bits without a negotiated extension.
  ClosedBecause(std::string("\xf1\x80\0\0\0\0", 6));
  ClosedBecause(std::string("\x81\xff\x7f\xff\xff\xff\xff\xff\xff\xff\0\0\0\0",
                            14));  // announces 2^63 bytes
  ClosedBecause(std::string("\x88\xfe\x10\x00", 4) +
                std::string(4100, 'x'));                               // a close that is too long
  ClosedBecause(std::string("\x81\x84\0\0\0\0\xff\xfe\xfd\xfc", 10));  // no UTF-8
  ExpectSound();
}

TEST_F(HostileVisitorTest, AMessageThatIsTooLongEndsTheLine) {
  PageClient page(server_.endpoint());
  page.Upgrade(Host(), "");
  page.SendText(std::string(kMaxCommandBytes + 1, 'x'));
  EXPECT_TRUE(page.ReadFrame(kClose));
  ExpectSound();
}

TEST_F(HostileVisitorTest, AFloodIsClosed) {
  PageClient page(server_.endpoint());
  page.Upgrade(Host(), "");
  for (int i = 0; i < 20 * PageServer::kMaxCommands; ++i) {
    if (!page.SendText(R"({"do":"ping","at":1})")) break;
  }
  const auto close = page.ReadFrame(kClose);
  ASSERT_TRUE(close);
  EXPECT_THAT(close->reason(), HasSubstr("messages in a second"));
  ExpectSound();
}

TEST_F(HostileVisitorTest, TooManyPagesAreRefusedAndMakeRoomWhenTheyLeave) {
  {
    std::vector<std::unique_ptr<PageClient>> pages;
    for (std::size_t i = 0; i < PageServer::kMaxPages; ++i) {
      pages.push_back(std::make_unique<PageClient>(server_.endpoint()));
      ASSERT_THAT(pages.back()->Upgrade(Host(), ""), HasSubstr("101"));
    }
    PageClient late(server_.endpoint());
    EXPECT_THAT(late.Upgrade(Host(), ""), HasSubstr("503"));
  }
  for (int i = 0; i < 1000 && server_.pages() > 0; ++i)
    std::this_thread::sleep_for(std::chrono::milliseconds(10));
  ExpectSound();
}

TEST_F(HostileVisitorTest, SilentConnectionsKeepNobodyOut) {
  std::vector<std::unique_ptr<PageClient>> idle;
  for (std::size_t i = 0; i < 2 * PageServer::kMaxConnections; ++i)
    idle.push_back(std::make_unique<PageClient>(server_.endpoint()));
  ExpectSound();
  EXPECT_EQ(idle.front()->ReadAll(), "") << "the oldest is closed";
}

TEST(UnfinishedSetUpTest, OnlyAsMuchIsTakenAsTheMemoryAllows) {
  const NoticeBoard board;
  PageServer::Listener listener{[](std::uint64_t, std::string_view) { return std::string(); },
                                [](std::uint64_t) {}};
  listener.set_up = [](std::string, std::string, const PageServer::Listener::Done& done) {
    done(200, "{}");
  };
  const PageServer server({"127.0.0.1", 0}, &board, std::move(listener));
  const std::string host = ToString(server.endpoint());
  const auto head = [&](const std::string& length) {
    return "POST /setup/image HTTP/1.1\r\nHost: " + host + "\r\nContent-Length: " + length +
           "\r\n\r\n";
  };
  std::optional<PageClient> one(server.endpoint());
  one->Send(head("40000000") + "{");
  // The order in which connections are read is open: one of the two is refused.
  PageClient other(server.endpoint());
  other.Send(head("40000000") + "{");
  one->Send(std::string(1000, ' '));
  EXPECT_THAT(other.ReadUntil("\r\n"), StartsWith("HTTP/1.1 503"));
  PageClient small(server.endpoint());
  small.Send(head("2") + "{}");
  EXPECT_THAT(small.ReadUntil("\r\n"), StartsWith("HTTP/1.1 200"));
  one.reset();
  EXPECT_TRUE(Eventually([&] {
    PageClient next(server.endpoint());
    next.Send(head("40000000") + std::string(1000, ' '));
    next.Send(std::string(39'999'000, ' '));
    return next.ReadUntil("\r\n").starts_with("HTTP/1.1 200");
  }));
}

}  // namespace
}  // namespace palpate
