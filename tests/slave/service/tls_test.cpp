// Tests mutual TLS with certificates from deploy/certs, and which calls each certificate permits.
#include <cstdlib>
#include <filesystem>
#include <fstream>
#include <string>
#include <utility>
#include <vector>

#include <gmock/gmock.h>
#include <gtest/gtest.h>
#include <unistd.h>

#include "master/link/slave_link.h"
#include "shared/link/latest_value.h"
#include "shared/text/text.h"
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

  static fs::path Folder() {
    return fs::path(testing::TempDir()) / ("palpate-tls." + std::to_string(getpid()));
  }
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
    arguments.SetInt(GRPC_ARG_ENABLE_HTTP_PROXY, 0);
    return grpc::CreateCustomChannel(server_->address(), credentials, arguments);
  }
  // Makes a certificate `name` that is valid for `seconds` (deploy/certs uses days) and otherwise
  // like that of `whose`, for `names`.
  static void CertifyFor(int seconds, const std::string& name,
                         const std::string& whose = "operator",
                         const std::string& names = "URI:palpate://operator/ada") {
    const std::string ca = At("ca"), out = At(name);
    fs::copy(At(whose), out);
    std::ofstream(out + "/index") << "";
    std::ofstream(out + "/ext") << "subjectAltName=" << names << "\n";
    std::ofstream(out + "/conf") << "[ca]\ndefault_ca=d\n[d]\ndatabase=" << out
                                 << "/index\nnew_certs_dir=" << out
                                 << "\nrand_serial=yes\npolicy=p\n[p]\ncommonName=supplied\n";
    Shell("openssl req -new -key " + out + "/key.pem -subj /CN=ada -out " + out + "/request");
    Shell("openssl ca -batch -notext -md default -config " + out + "/conf -keyfile " + ca +
          "/ca.key -cert " + ca + "/ca.pem -in " + out + "/request -out " + out +
          "/cert.pem -extfile " + out + "/ext -enddate $(date -u -d '+" + std::to_string(seconds) +
          " seconds' +%y%m%d%H%M%SZ)");
  }
  static grpc::StatusCode Stop(v1::Teleoperation::Stub& stub) {
    CallContext context;
    v1::Status reply;
    return stub.Stop(&context, {}, &reply).error_code();
  }
  static grpc::StatusCode SetParameters(v1::Teleoperation::Stub& stub) {
    CallContext context;
    v1::SettingsReply reply;
    return stub.SetParameters(&context, {}, &reply).error_code();
  }
  static grpc::StatusCode Evict(v1::Teleoperation::Stub& stub) {
    CallContext context;
    v1::Status reply;
    return stub.EvictOperator(&context, {}, &reply).error_code();
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

TEST_F(TlsTest, ClientsWithoutACertificateOfThisCaAreRefused) {
  EXPECT_EQ(Stop(*As("stranger")), grpc::StatusCode::UNAVAILABLE);
  EXPECT_EQ(Stop(*As("expired")), grpc::StatusCode::UNAVAILABLE);
  const auto plain = v1::Teleoperation::NewStub(OpenAs(grpc::InsecureChannelCredentials()));
  EXPECT_EQ(Stop(*plain), grpc::StatusCode::UNAVAILABLE);
  EXPECT_EQ(slave_.stop_reason(), "");
  EXPECT_EQ(slave_.Status().phase, Phase::kReady);
}

// In an earlier version a stream outlived the certificate with which it began.
TEST_F(TlsTest, AStreamOutlivesNoCertificate) {
  CertifyFor(4, "brief");
  Operator ada(As("brief"));
  ada.Hold(0, "Ada");
  ASSERT_TRUE(ada.ReadUntil([](const auto& s) { return s.phase() == v1::PHASE_FOLLOWING; }));
  EXPECT_FALSE(ada.Finish().ok());
  EXPECT_TRUE(Eventually([&] { return slave_.Status().phase == Phase::kReady; }))
      << "the tool is at rest";
  EXPECT_EQ(Stop(*As("brief")), grpc::StatusCode::UNAVAILABLE);
}

// A client whose certificate is no longer accepted moves no tool.
TEST_F(TlsTest, TheOperatorsStreamOutlivesNoCertificateOfTheSlave) {
  CertifyFor(4, "brief-slave", "slave", "URI:palpate://slave/here,DNS:localhost,IP:127.0.0.1");
  server_.reset();
  server_ = std::make_unique<Server>(slave_, "127.0.0.1:0", false, At("brief-slave"));
  SlaveLink::Options options;
  options.target = server_->address();
  options.tls = At("operator");
  LatestValue<ReceivedState> states;
  LatestValue<OperatorCommand> commands;
  LatestValue<RemoteSettings> settings;
  SlaveLink link(options);
  link.Start(&states, &commands, &settings, true);
  ASSERT_TRUE(Eventually([&] { return link.stats().connected; }));
  EXPECT_TRUE(Eventually([&] {
    return link.stats().trouble.find("the slave's certificate is no longer valid") !=
           std::string::npos;
  }));
}

// gRPC's information about a peer with this certificate and name.
class Peer final : public grpc::AuthContext {
 public:
  Peer(std::string certificate, std::string name)
      : certificate_(std::move(certificate)), name_(std::move(name)) {}
  bool IsPeerAuthenticated() const override { return true; }
  std::vector<grpc::string_ref> GetPeerIdentity() const override { return {}; }
  std::string GetPeerIdentityPropertyName() const override { return {}; }
  std::vector<grpc::string_ref> FindPropertyValues(const std::string& name) const override {
    if (name == GRPC_X509_PEM_CERT_PROPERTY_NAME) return {certificate_};
    if (name == GRPC_X509_SAN_PROPERTY_NAME) return {name_};
    return {};
  }
  grpc::AuthPropertyIterator begin() const override { return Nothing(); }
  grpc::AuthPropertyIterator end() const override { return Nothing(); }
  void AddProperty(const std::string& /*key*/, const grpc::string_ref& /*value*/) override {}
  bool SetPeerIdentityPropertyName(const std::string& /*name*/) override { return false; }

 private:
  struct Nothing : grpc::AuthPropertyIterator {};
  const std::string certificate_, name_;
};

// The connection was opened before the certificate expired.
TEST_F(TlsTest, EachCallWithACertificateThatExpiredIsRefused) {
  const auto check = RoleCheck();
  const auto answer = [&](const std::string& who) {
    Peer peer(ReadWholeFile(At(who) + "/cert.pem", 1 << 16, "a certificate"),
              "palpate://operator/ada");
    grpc::AuthMetadataProcessor::OutputMetadata consumed, response;
    return check
        ->Process({{":path", "/palpate.v1.Teleoperation/GetScene"}}, &peer, &consumed, &response)
        .error_code();
  };
  EXPECT_EQ(answer("operator"), grpc::StatusCode::OK);
  EXPECT_EQ(answer("expired"), grpc::StatusCode::UNAUTHENTICATED);
}

TEST_F(TlsTest, AnArmsDriverOutlivesNoCertificate) {
  slave_.TakeArm({});
  CertifyFor(4, "brief-robot", "arm", "URI:palpate://arm/robot");
  const auto robot = As("brief-robot");
  CallContext context;
  const auto stream = robot->DriveTool(&context);
  v1::ArmReport report;
  report.set_sequence(1);
  report.mutable_measured_at()->set_seconds(1);
  report.mutable_p_s_tip()->set_x(0);
  for (const double part : {1, 0, 0, 0}) report.add_orientation(part);
  ASSERT_TRUE(stream->Write(report));
  v1::ArmTarget target;
  ASSERT_TRUE(stream->Read(&target));
  while (stream->Read(&target)) {
  }
  EXPECT_EQ(stream->Finish().error_code(), grpc::StatusCode::UNAVAILABLE);
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
  EXPECT_THAT(
      Operator(As("observer")).Finish(),
      EndedWith(grpc::StatusCode::PERMISSION_DENIED, HasSubstr("role 'observer' may not call")));
  EXPECT_EQ(slave_.begins(), 0) << "the lease was not touched";
  EXPECT_EQ(Evict(*As("operator")), grpc::StatusCode::PERMISSION_DENIED);
  EXPECT_EQ(Evict(*As("admin")), grpc::StatusCode::FAILED_PRECONDITION) << "nobody operates";
  EXPECT_EQ(Stop(*As("arm")), grpc::StatusCode::OK) << "anyone with a role may stop";
}

TEST_F(TlsTest, WhatIsMissingOrOpenToOthersIsNamed) {
  EXPECT_THROW(ChannelTls(At("nowhere")), std::invalid_argument);
  const std::string key = At("admin") + "/key.pem";
  for (const auto reader : {fs::perms::group_read, fs::perms::others_read}) {
    fs::permissions(key, reader, fs::perm_options::add);
    EXPECT_THROW(ChannelTls(At("admin")), std::invalid_argument);
    fs::permissions(key, reader, fs::perm_options::remove);
  }
}

TEST_F(TlsTest, ExpiredAndFutureCertificatesAreNamed) {
  constexpr std::chrono::hours kYear(24 * 366);
  const auto now = std::chrono::system_clock::now();
  EXPECT_EQ(WhyUntimely(At("operator")), "");
  EXPECT_THAT(WhyUntimely(At("expired")), HasSubstr("expired/cert.pem expired on "));
  EXPECT_THAT(WhyUntimely(At("operator"), now + kYear), HasSubstr("cert.pem expired on"));
  EXPECT_THAT(WhyUntimely(At("operator"), now + 11 * kYear), HasSubstr("ca.pem expired on"));
  EXPECT_THAT(WhyUntimely(At("operator"), now - kYear), HasSubstr("ca.pem is valid only from "));
}

TEST_F(TlsTest, AnEmergencyStopIsClearedByWhoOperatesOrByAnAdmin) {
  const auto reset = [](v1::Teleoperation::Stub& stub) {
    grpc::ClientContext for_status, context;
    v1::Status reply;
    EXPECT_TRUE(stub.GetStatus(&for_status, {}, &reply).ok());
    v1::ResetRequest request;
    request.set_stops(reply.stops());
    return stub.Reset(&context, request, &reply).error_code();
  };
  const auto ada = As("operator"), admin = As("admin");
  ASSERT_EQ(Stop(*ada), grpc::StatusCode::OK);
  EXPECT_EQ(reset(*ada), grpc::StatusCode::FAILED_PRECONDITION) << "she does not operate";
  EXPECT_EQ(slave_.Status().phase, Phase::kEstop);
  {
    grpc::ClientContext context;
    const auto stream = ada->Operate(&context);
    v1::SlaveState state;
    ASSERT_TRUE(stream->Read(&state));
    EXPECT_EQ(reset(*ada), grpc::StatusCode::OK);
    context.TryCancel();
    static_cast<void>(stream->Finish());
  }
  EXPECT_EQ(slave_.Status().phase, Phase::kReady);
  EXPECT_EQ(reset(*ada), grpc::StatusCode::OK) << "no stop is active";
  ASSERT_EQ(Stop(*ada), grpc::StatusCode::OK);
  EXPECT_EQ(reset(*admin), grpc::StatusCode::OK);
  EXPECT_EQ(slave_.Status().phase, Phase::kReady);
}

// Reference: the roles of proto/README.md, one line each. All other calls are refused.
TEST(RolesTest, TheWholeTable) {
  const std::vector<std::string> methods{
      "GetScene",     "GetStatus",   "Operate",       "WatchState",
      "WatchMesh",    "WatchImages", "SetModel",      "Reset",
      "Stop",         "FeedTactile", "SetParameters", "FeedImages",
      "DriveTool",    "WatchPatch",  "WatchTrace",    "ReinitializeTracking",
      "ProposeScene", "UseScene",    "FindOutline",   "FindBoard"};
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
  EXPECT_EQ(allowed("operator"), "xxxxxxxxx.x..xxx....x.....");
  EXPECT_EQ(allowed("observer"), "xx.xxx..x....xx.....x.....");
  EXPECT_EQ(allowed("sensor"), "xx......xx.x........x.....");
  EXPECT_EQ(allowed("arm"), "xx......x...x.......x.....");
  EXPECT_EQ(allowed("admin"), "xx.xxxxxx.x..xxxxxxxx....x");
  for (const char* none : {"", "slave", "Operator", "root"}) {
    EXPECT_EQ(allowed(none), std::string(methods.size() + 6, '.')) << none;
  }
}

TEST(RolesTest, AnIdentityIsAnAlternativeNameOfOurs) {
  EXPECT_EQ(ParseIdentity("palpate://operator/ada").name, "ada");
  EXPECT_EQ(ParseIdentity("palpate://operator/a\nb").name, "a b");
  for (const char* none : {"operator", "palpate://owner/eve", "palpate://operator",
                           "palpate://operator/", "localhost", ""}) {
    EXPECT_EQ(ParseIdentity(none).role, "") << none;
  }
}

}  // namespace
}  // namespace palpate
