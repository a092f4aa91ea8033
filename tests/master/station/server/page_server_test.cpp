// Tests the server from the view of a page.
#include "master/station/server/page_server.h"

#include <atomic>
#include <stdexcept>
#include <thread>

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include "tests/master/station/server/page_client.h"
#include "tests/support/eventually.h"
#include "tests/support/thrown.h"

namespace palpate {
namespace {

using testing::HasSubstr;
using testing::Not;
using testing::StartsWith;

class PageServerTest : public testing::Test {
 protected:
  [[nodiscard]] std::string Host() const { return ToString(server_.endpoint()); }
  [[nodiscard]] std::string Origin() const { return "http://" + Host(); }
  std::string Get(const std::string& target) {
    PageClient client(server_.endpoint());
    client.Send("GET " + target + " HTTP/1.1\r\nHost: " + Host() + "\r\n\r\n");
    return client.ReadAll();
  }
  void Put(Topic topic, std::string message) {
    board_.Put(topic, std::move(message));
    server_.Notify();
  }

  NoticeBoard board_;
  std::atomic<int> left_{0};
  PageServer server_{{"127.0.0.1", 0},
                     &board_,
                     {[](std::uint64_t /*page*/, std::string_view message) -> std::string {
                        if (message == "nonsense") throw std::invalid_argument("not understood");
                        return "heard " + std::string(message);
                      },
                      [this](std::uint64_t /*page*/) { ++left_; }}};
};

TEST_F(PageServerTest, ServesThePageAndNothingFromElsewhere) {
  const std::string page = Get("/");
  EXPECT_THAT(page, StartsWith("HTTP/1.1 200"));
  EXPECT_THAT(page, HasSubstr("<title>Palpate"));
  EXPECT_THAT(page, HasSubstr("default-src 'none'"));
  EXPECT_THAT(page, HasSubstr("nosniff"));
  for (const char* file : {"/main.js", "/style.css", "/main.js?again"}) {
    const std::string answer = Get(file);
    EXPECT_THAT(answer, StartsWith("HTTP/1.1 200")) << file;
    EXPECT_THAT(answer, Not(HasSubstr("https://"))) << file << " works without a network";
  }
}

TEST_F(PageServerTest, SendsANewPageTheBoardAndThenNewMessages) {
  Put(Topic::kHello, "hello");
  Put(Topic::kImage, "an image");
  PageClient page(server_.endpoint());
  ASSERT_THAT(page.Upgrade(Host(), Origin()), HasSubstr("101"));
  const auto first = page.ReadFrame(), second = page.ReadFrame();
  ASSERT_TRUE(first && second);
  EXPECT_EQ(first->opcode, kText);
  EXPECT_EQ(first->payload, "hello");
  EXPECT_EQ(second->opcode, kBinary);
  EXPECT_EQ(second->payload, "an image");
  Put(Topic::kStatus, "now");
  const auto third = page.ReadFrame();
  ASSERT_TRUE(third);
  EXPECT_EQ(third->payload, "now");
}

// A page that does not read delays no other page. It misses the messages that were replaced in the
// meantime and gets the newest one when it reads again. The messages in between are bounded by the
// two socket buffers (0.25 MB each) and one message: three of kSize. All are sent well within the
// time after which the server drops a page that does not read.
TEST_F(PageServerTest, ASlowPageGetsTheNewestAndNothingPilesUp) {
  constexpr int kMessages = 40, kSize = 256 << 10;
  PageClient slow(server_.endpoint(), {128 << 10, 1400});
  ASSERT_THAT(slow.Upgrade(Host(), Origin()), HasSubstr("101"));
  PageClient quick(server_.endpoint());
  ASSERT_THAT(quick.Upgrade(Host(), Origin()), HasSubstr("101"));
  for (int i = 1; i <= kMessages; ++i) {
    std::string message(kSize, '.');
    message.replace(0, 4, std::to_string(1000 + i));
    Put(Topic::kShape, message);
    const auto frame = quick.ReadFrame(kBinary);
    ASSERT_TRUE(frame);
    ASSERT_EQ(frame->payload.substr(0, 4), std::to_string(1000 + i)) << "the quick one misses none";
  }
  int came = 0;
  std::string last;
  while (last != std::to_string(1000 + kMessages)) {
    const auto frame = slow.ReadFrame(kBinary);
    ASSERT_TRUE(frame);
    last = frame->payload.substr(0, 4);
    ++came;
  }
  EXPECT_LE(came, 8) << "old messages had waited for the slow page";
}

std::string Count(std::uint32_t taken) {
  return {reinterpret_cast<const char*>(&taken), sizeof taken};
}

// A browser keeps reading while its page is busy; data that the page cannot use is not sent.
TEST_F(PageServerTest, APageThatConfirmsReceiptGetsTheNewestNext) {
  constexpr int kAhead = 8;
  PageClient page(server_.endpoint());
  ASSERT_THAT(page.Upgrade(Host(), Origin()), HasSubstr("101"));
  page.SendBinary(Count(0));
  page.SendText("you");  // answered once the count was received
  ASSERT_TRUE(page.ReadFrame(kText));
  int last = 0;
  for (; last < kAhead - 1; ++last) {
    Put(Topic::kStatus, std::to_string(last));
    ASSERT_TRUE(page.ReadFrame(kText));
  }
  for (; last < 50; ++last) Put(Topic::kStatus, std::to_string(last));
  page.SendBinary(Count(kAhead));
  const auto next = page.ReadFrame(kText);
  ASSERT_TRUE(next);
  EXPECT_EQ(next->payload, "49");
}

TEST_F(PageServerTest, ACountThatIsNoneEndsTheLineWithTheReason) {
  for (const std::string& message : {std::string("123"), Count(1'000'000)}) {
    PageClient page(server_.endpoint());
    ASSERT_THAT(page.Upgrade(Host(), Origin()), HasSubstr("101"));
    page.SendBinary(message);
    const auto frame = page.ReadFrame(kClose);
    ASSERT_TRUE(frame);
    EXPECT_THAT(frame->reason(), HasSubstr("the number of messages received"));
  }
}

TEST_F(PageServerTest, ReportsPagesThatLeft) {
  {
    PageClient page(server_.endpoint());
    ASSERT_THAT(page.Upgrade(Host(), Origin()), HasSubstr("101"));
    ASSERT_TRUE(Eventually([this] { return server_.pages() == 1; }));
  }
  EXPECT_TRUE(Eventually([this] { return left_ == 1 && server_.pages() == 0; }));
}

// The set-up's requests carry images, which a message of a page may not.
class PageSetupTest : public testing::Test {
 protected:
  std::string Post(const std::string& target, const std::string& body,
                   const std::string& origin = {}) {
    const std::string host = ToString(server_.endpoint());
    PageClient client(server_.endpoint());
    client.Send("POST " + target + " HTTP/1.1\r\nHost: " + host + "\r\n" +
                (origin.empty() ? "" : "Origin: " + origin + "\r\n") +
                "Content-Length: " + std::to_string(body.size()) + "\r\n\r\n");
    client.Send(body);
    return client.ReadAll();
  }

  NoticeBoard board_;
  std::atomic<int> calls_{0};
  std::jthread slave_;
  PageServer server_{
      {"127.0.0.1", 0},
      &board_,
      {[](std::uint64_t /*page*/, std::string_view /*message*/) { return std::string(); },
       [](std::uint64_t /*page*/) {},
       [this](const std::string& call, const std::string& json,
              const PageServer::Listener::Done& done) {
         ++calls_;
         slave_ = std::jthread([=] {  // answers later and on a separate thread, like a slave
           done(call == "propose" ? 200 : 409,
                R"({"call":")" + call + R"(","bytes":)" + std::to_string(json.size()) + "}");
         });
       }}};
};

TEST_F(PageSetupTest, ARequestOfAnImageIsForwardedAndAnswered) {
  const std::string answer = Post("/setup/propose", std::string(3'000'000, 'x'));
  EXPECT_THAT(answer, StartsWith("HTTP/1.1 200"));
  EXPECT_THAT(answer, HasSubstr(R"({"call":"propose","bytes":3000000})"));
  EXPECT_THAT(Post("/setup/use?token=1", "{}"), StartsWith("HTTP/1.1 409"));
}

TEST_F(PageSetupTest, AnotherPageAndARequestThatIsTooLongAreRefused) {
  EXPECT_THAT(Post("/setup/use", "{}", "http://evil.example"), StartsWith("HTTP/1.1 403"));
  EXPECT_THAT(Post("/setup/use", std::string(PageServer::kMaxSetupBytes + 1, 'x')),
              StartsWith("HTTP/1.1 400"));
  EXPECT_THAT(Post("/index.html", "{}"), StartsWith("HTTP/1.1 405"));
  EXPECT_EQ(calls_, 0);
}

TEST_F(PageServerTest, AStationWithoutASetupForwardsNothing) {
  PageClient client(server_.endpoint());
  client.Send("POST /setup/use HTTP/1.1\r\nHost: " + Host() + "\r\nContent-Length: 2\r\n\r\n{}");
  EXPECT_THAT(client.ReadAll(), StartsWith("HTTP/1.1 405"));
}

}  // namespace
}  // namespace palpate
