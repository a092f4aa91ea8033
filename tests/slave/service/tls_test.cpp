// Mutual TLS with certificates as deploy/certs makes them, and who may call what with them.
#include <cstdlib>
#include <filesystem>
#include <string>
#include <vector>

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include "shared/tls/credentials.h"
#include "slave/service/roles.h"
#include "tests/slave/service/service_fixture.h"
#include "tests/support/paths.h"

namespace palpate {
namespace {

namespace fs = std::filesystem;
using testing::HasSubstr;

bool Shell(const std::string& command) {
  return std::system((command + " >/dev/null 2>&1").c_str()) == 0;
}

class TlsTest : public testing::Test {
 protected:
  static void SetUpTestSuite() {
    fs::remove_all(Folder());
    Certs("ca " + At("ca"));
    Certs("ca " + At("strangers-ca"));
    Certs("slave " + At("ca") + " " + At("slave") + " here localhost 127.0.0.1");
    for (const std::string role : {"operator", "observer", "sensor", "arm", "admin"}) {
      Certs(role + " " + At("ca") + " " + At(role) + " ada");
    }
    Certs("operator " + At("strangers-ca") + " " + At("stranger") + " eve");
    Certs("operator " + At("ca") + " " + At("expired") + " ada", "DAYS=0 ");
  }
  static void TearDownTestSuite() { fs::remove_all(Folder()); }

  void SetUp() override {
    if (!fs::exists(At("slave") + "/cert.pem")) GTEST_SKIP() << "no openssl";
    server_ = std::make_unique<Server>(slave_, "127.0.0.1:0", false, At("slave"));
  }

  static fs::path Folder() { return fs::path(testing::TempDir()) / "palpate-tls"; }
  static std::string At(const std::string& name) { return (Folder() / name).string(); }
  static void Certs(const std::string& arguments, const std::string& environment = "") {
    Shell(environment + SourcePath("/deploy/certs") + " " + arguments);
  }
  std::unique_ptr<v1::Teleoperation::Stub> As(const std::string& who) const {
    return v1::Teleoperation::NewStub(OpenAs(ChannelTls(At(who))));
  }
  std::shared_ptr<grpc::Channel> OpenAs(
      const std::shared_ptr<grpc::ChannelCredentials>& credentials) const {
    grpc::ChannelArguments arguments;
    arguments.SetInt(GRPC_ARG_USE_LOCAL_SUBCHANNEL_POOL, 1);
    return grpc::CreateCustomChannel(server_->address(), credentials, arguments);
  }
  static grpc::StatusCode Stop(v1::Teleoperation::Stub& stub) {
    grpc::ClientContext context;
    SetDeadline(&context);
    v1::Status reply;
    return stub.Stop(&context, {}, &reply).error_code();
  }
  static grpc::StatusCode SetParameters(v1::Teleoperation::Stub& stub) {
    grpc::ClientContext context;
    SetDeadline(&context);
    v1::SettingsReply reply;
    return stub.SetParameters(&context, {}, &reply).error_code();
  }
  bool Handshakes(const std::string& how) const {
    return Shell("openssl s_client -brief -CAfile " + At("ca/ca.pem") + " -cert " +
                 At("operator/cert.pem") + " -key " + At("operator/key.pem") + " -connect " +
                 server_->address() + " " + how +
                 " -alpn h2 </dev/null 2>&1 | grep -q 'Protocol version: TLSv1'");
  }

  FakeSlave slave_;
  std::unique_ptr<Server> server_;
};

TEST_F(TlsTest, AnOperatorOperates) {
  Operator ada(As("operator"));
  ada.Hold(0, "Ada");
  ASSERT_TRUE(ada.ReadUntil([](const auto& s) { return s.phase() == v1::PHASE_FOLLOWING; }));
  EXPECT_TRUE(ada.Leave().ok());
}

TEST_F(TlsTest, WhoeverHasNoCertificateOfThisCaIsNotHeard) {
  EXPECT_EQ(Stop(*As("stranger")), grpc::StatusCode::UNAVAILABLE);
  EXPECT_EQ(Stop(*As("expired")), grpc::StatusCode::UNAVAILABLE);
  const auto plain = v1::Teleoperation::NewStub(OpenAs(grpc::InsecureChannelCredentials()));
  EXPECT_EQ(Stop(*plain), grpc::StatusCode::UNAVAILABLE);
  EXPECT_EQ(slave_.stop_reason(), "");
  EXPECT_EQ(slave_.Status().phase, Phase::kReady);
}

TEST_F(TlsTest, ADowngradeIsRefused) {
  EXPECT_TRUE(Handshakes("-tls1_3"));
  EXPECT_FALSE(Handshakes("-tls1_2"));
}

TEST_F(TlsTest, TheRoleDecidesWhoMayCallWhat) {
  EXPECT_EQ(SetParameters(*As("observer")), grpc::StatusCode::PERMISSION_DENIED);
  EXPECT_EQ(SetParameters(*As("sensor")), grpc::StatusCode::PERMISSION_DENIED);
  EXPECT_EQ(SetParameters(*As("operator")), grpc::StatusCode::OK);
  EXPECT_EQ(SetParameters(*As("admin")), grpc::StatusCode::OK);
  const grpc::Status refused = Operator(As("observer")).Finish();
  EXPECT_EQ(refused.error_code(), grpc::StatusCode::PERMISSION_DENIED);
  EXPECT_THAT(refused.error_message(), HasSubstr("role 'observer' may not call"));
  EXPECT_EQ(slave_.begins(), 0) << "the lease was not touched";
  EXPECT_EQ(Stop(*As("arm")), grpc::StatusCode::OK) << "anyone with a role may stop";
}

TEST_F(TlsTest, BeyondThisMachineTlsIsEnough) {
  EXPECT_NO_THROW(Server(slave_, "0.0.0.0:0", false, At("slave")));
}

TEST_F(TlsTest, WhatIsMissingOrOpenToOthersIsNamed) {
  EXPECT_THROW(ChannelTls(At("nowhere")), std::invalid_argument);
  const std::string key = At("admin") + "/key.pem";
  fs::permissions(key, fs::perms::others_read, fs::perm_options::add);
  EXPECT_THROW(ChannelTls(At("admin")), std::invalid_argument);
  fs::permissions(key, fs::perms::others_read, fs::perm_options::remove);
}

// Reference: the roles, one line each; whatever else is called, by anyone: no.
TEST(RolesTest, TheWholeTable) {
  const std::vector<std::string> methods{
      "GetScene",    "GetStatus",     "GetCapabilities", "Operate", "WatchState",
      "WatchMesh",   "WatchVideo",    "SetModel",        "Reset",   "Stop",
      "FeedTactile", "SetParameters", "WatchPatch"};
  const auto allowed = [&](const std::string& role) {
    std::string may;
    for (const std::string& method : methods) {
      may += MayCall(role, "/palpate.v1.Teleoperation/" + method) ? 'x' : '.';
    }
    for (const char* path : {"/grpc.health.v1.Health/Check", "/other.Service/Call", "", "/x",
                             "/palpate.v1.Teleoperation/Unknown",
                             "/grpc.reflection.v1alpha.ServerReflection/ServerReflectionInfo"}) {
      may += MayCall(role, path) ? 'x' : '.';
    }
    return may;
  };
  EXPECT_EQ(allowed("operator"), "xxxxxxxxxx.xxx.....");
  EXPECT_EQ(allowed("observer"), "xxx.xxx..x..xx.....");
  EXPECT_EQ(allowed("sensor"), "xxx......xx..x.....");
  EXPECT_EQ(allowed("arm"), "xxx......x...x.....");
  EXPECT_EQ(allowed("admin"), "xxx.xxxxxx.xxx....x");
  for (const char* none : {"", "slave", "Operator", "root"}) {
    EXPECT_EQ(allowed(none), std::string(19, '.')) << none;
  }
}

TEST(RolesTest, AnIdentityIsAnAlternativeNameOfOurs) {
  EXPECT_EQ(ParseIdentity("palpate://operator/ada").name, "ada");
  EXPECT_EQ(ParseIdentity("palpate://operator/a\nb").name, "a b");
  for (const char* none :
       {"operator", "palpate://owner/eve", "palpate://operator", "localhost", ""}) {
    EXPECT_EQ(ParseIdentity(none).role, "") << none;
  }
}

}  // namespace
}  // namespace palpate
