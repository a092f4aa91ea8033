// The page beyond this machine: with TLS and a token, or not at all.
#include "master/station/server/page_access.h"

#include <cstdlib>
#include <filesystem>
#include <fstream>
#include <memory>
#include <stdexcept>

#include <boost/asio.hpp>
#include <boost/asio/ssl.hpp>
#include <gmock/gmock.h>
#include <gtest/gtest.h>
#include <openssl/x509.h>
#include <unistd.h>

#include "master/station/server/page_server.h"
#include "tests/master/station/server/page_client.h"
#include "tests/support/paths.h"
#include "tests/support/thrown.h"

namespace palpate {
namespace {

namespace asio = boost::asio;
namespace fs = std::filesystem;
using testing::HasSubstr;
using testing::StartsWith;

std::string WordsOf(const std::string& view, const fs::path& tls) {
  return Thrown<std::invalid_argument>([&] { ViewPlace(view, tls); });
}

class PageAccessTest : public testing::Test {
 protected:
  static void SetUpTestSuite() {
    Certs("ca " + At("ca"));
    Certs("operator " + At("ca") + " " + At("page") + " ada 127.0.0.1 10.0.0.5");
    Certs("operator " + At("ca") + " " + At("plain") + " ada");
  }
  static void TearDownTestSuite() { fs::remove_all(Folder()); }
  void SetUp() override {
    if (!fs::exists(At("page") + "/cert.pem")) GTEST_SKIP() << "no openssl";
  }

  static fs::path Folder() {
    return fs::path(testing::TempDir()) / ("page-access." + std::to_string(getpid()));
  }
  static std::string At(const std::string& name) { return (Folder() / name).string(); }
  static void Certs(const std::string& arguments) {
    const std::string command = SourcePath("/deploy/certs") + " " + arguments + " >/dev/null 2>&1";
    [[maybe_unused]] const int status = std::system(command.c_str());
  }
};

TEST_F(PageAccessTest, BeyondItIsRefusedWithoutTls) {
  for (const char* view : {"10.0.0.5:8080", "0.0.0.0:0", "[::]:0", "station.example:80"}) {
    EXPECT_THAT(WordsOf(view, {}), HasSubstr("it needs TLS: expected --tls DIR")) << view;
  }
}

TEST_F(PageAccessTest, ACertificateForNoPageOrAnotherHostIsRefused) {
  EXPECT_EQ(WordsOf("10.0.0.5:0", At("page")), "");
  EXPECT_THAT(WordsOf("10.0.0.5:0", At("plain")), HasSubstr("deploy/certs operator CA OUT NAME"));
  EXPECT_THAT(WordsOf("10.0.0.6:0", At("page")),
              HasSubstr("no certificate for a page at 10.0.0.6"));
  EXPECT_THAT(WordsOf("10.0.0.5:0", At("nobody")), HasSubstr("is missing"));
}

TEST_F(PageAccessTest, EachStartHasATokenOfItsOwn) {
  const std::string one = MakePageAccess(At("page"), "127.0.0.1").token;
  EXPECT_EQ(one.size(), 32U);
  EXPECT_NE(one, MakePageAccess(At("page"), "127.0.0.1").token);
}

TEST(CarriesTokenTest, OnlyTheTokenInItsPlaceIsAccepted) {
  EXPECT_TRUE(CarriesToken("/ws?token=0123", "0123"));
  EXPECT_TRUE(CarriesToken("/setup/use?token=0123", "0123"));
  for (const char* target : {"/ws", "/ws?token=", "/ws?token=012", "/ws?token=01234",
                             "/ws?token=0124", "?x?token=0123", "/ws?x=1&token=0123", ""}) {
    EXPECT_FALSE(CarriesToken(target, "0123")) << target;
  }
}

class TlsPageTest : public PageAccessTest {
 protected:
  void SetUp() override {
    PageAccessTest::SetUp();
    if (IsSkipped()) return;
    access_ = MakePageAccess(At("page"), "127.0.0.1");
    server_ = std::make_unique<PageServer>(
        Endpoint{"127.0.0.1", 0}, &board_,
        PageServer::Listener{[](std::uint64_t, std::string_view) { return std::string(); },
                             [](std::uint64_t) {}},
        access_);
  }
  // Returns the answer to `request` up to `end`, or as much of it as arrives. `serial`: of the
  // page's certificate.
  std::string Query(const std::string& request, const std::string& end,
                    std::string* serial = nullptr) {
    asio::io_context context;
    asio::ssl::context tls(asio::ssl::context::tls_client);
    tls.load_verify_file(At("page") + "/ca.pem");
    tls.set_verify_mode(asio::ssl::verify_peer);
    asio::ssl::stream<asio::ip::tcp::socket> line(context, tls);
    line.next_layer().connect({asio::ip::make_address("127.0.0.1"), server_->endpoint().port});
    line.handshake(asio::ssl::stream_base::client);
    if (serial != nullptr) {
      const std::unique_ptr<X509, decltype(&X509_free)> shown(
          SSL_get1_peer_certificate(line.native_handle()), X509_free);
      const ASN1_INTEGER* number = X509_get0_serialNumber(shown.get());
      serial->assign(reinterpret_cast<const char*>(number->data), number->length);
    }
    asio::write(line, asio::buffer(request));
    std::string answer;
    boost::system::error_code error;
    asio::read_until(line, asio::dynamic_buffer(answer), end, error);
    return answer;
  }
  std::string Upgrade(const std::string& target, const std::string& origin) {
    return Query(
        "GET " + target + " HTTP/1.1\r\nHost: station.example\r\nOrigin: " + origin +
            "\r\nUpgrade: websocket\r\nConnection: Upgrade\r\nSec-WebSocket-Version: 13\r\n"
            "Sec-WebSocket-Key: dGhlIHNhbXBsZSBub25jZQ==\r\n\r\n",
        "\r\n\r\n");
  }

  NoticeBoard board_;
  PageAccess access_;
  std::unique_ptr<PageServer> server_;
};

TEST_F(TlsPageTest, ServesThePageInTlsAlone) {
  EXPECT_THAT(Query("GET / HTTP/1.1\r\nHost: station.example\r\n\r\n", "</html>"),
              HasSubstr("<title>Palpate"));
  PageClient plain(server_->endpoint());
  plain.Send("GET / HTTP/1.1\r\nHost: 127.0.0.1\r\n\r\n");
  EXPECT_THAT(plain.ReadAll(), testing::Not(HasSubstr("HTTP/1.1")));
}

TEST_F(TlsPageTest, ARenewedCertificateIsServedToTheNextBrowser) {
  const std::string request = "GET / HTTP/1.1\r\nHost: station.example\r\n\r\n";
  std::string before, after, last;
  Query(request, "</html>", &before);
  Certs("operator " + At("ca") + " " + At("page") + " ada 127.0.0.1 10.0.0.5");
  EXPECT_THAT(Query(request, "</html>", &after), HasSubstr("<title>Palpate"));
  EXPECT_NE(after, before);
  std::ofstream(At("page") + "/cert.pem") << "half a certif";
  EXPECT_THAT(Query(request, "</html>", &last), HasSubstr("<title>Palpate"));
  EXPECT_EQ(last, after);
  Certs("operator " + At("ca") + " " + At("page") + " ada 127.0.0.1 10.0.0.5");
}

TEST_F(TlsPageTest, OperatesWithTheTokenAlone) {
  const std::string own = "https://station.example";
  EXPECT_THAT(server_->address(), testing::EndsWith("/#" + access_.token));
  EXPECT_THAT(Upgrade("/ws?token=" + access_.token, own), StartsWith("HTTP/1.1 101"));
  EXPECT_THAT(Upgrade("/ws", own), StartsWith("HTTP/1.1 403"));
  EXPECT_THAT(Upgrade("/ws?token=" + std::string(32, '0'), own), StartsWith("HTTP/1.1 403"));
  EXPECT_THAT(Upgrade("/ws?token=" + access_.token, "https://evil.example"),
              StartsWith("HTTP/1.1 403"));
}

}  // namespace
}  // namespace palpate
