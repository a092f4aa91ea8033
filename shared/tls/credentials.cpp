#include "shared/tls/credentials.h"

#include <cstdlib>
#include <stdexcept>
#include <string>
#include <utility>

#include <grpcpp/security/tls_certificate_provider.h>
#include <grpcpp/security/tls_certificate_verifier.h>
#include <grpcpp/security/tls_credentials_options.h>
#include <spdlog/spdlog.h>

namespace palpate {
namespace {

namespace fs = std::filesystem;

constexpr unsigned kRefresh = 1;  // [s]

void RequireFile(const fs::path& file) {
  if (fs::is_regular_file(file)) return;
  throw std::invalid_argument(file.string() + " is missing: deploy/certs makes it");
}

void RequirePrivate(const fs::path& key) {
  const auto others = fs::perms::group_all | fs::perms::others_all;
  if ((fs::status(key).permissions() & others) == fs::perms::none) return;
  throw std::invalid_argument(key.string() + " may be read by others: accepted is mode 0600");
}

// This gRPC has no setting for it: of the suites before 1.3 only one is left that needs a secret
// shared beforehand, which there is none of.
void AllowOnlyTls13() {
  setenv("GRPC_SSL_CIPHER_SUITES", "PSK-AES128-GCM-SHA256", 1);
}

std::shared_ptr<grpc::experimental::CertificateProviderInterface> Watched(const fs::path& folder) {
  RequireCertificates(folder);
  const fs::path ca = folder / "ca.pem", cert = folder / "cert.pem", key = folder / "key.pem";
  AllowOnlyTls13();
  return std::make_shared<grpc::experimental::FileWatcherCertificateProvider>(
      key.string(), cert.string(), ca.string(), kRefresh);
}

// After the chain was verified.
class NotRevoked final : public grpc::experimental::ExternalCertificateVerifier {
 public:
  explicit NotRevoked(std::shared_ptr<RevocationList> revoked) : revoked_(std::move(revoked)) {}
  ~NotRevoked() override = default;
  bool Verify(grpc::experimental::TlsCustomVerificationCheckRequest* request,
              std::function<void(grpc::Status)> /*when_done*/, grpc::Status* status) override {
    const auto peer = request->peer_cert();
    const auto facts = FactsOf(std::string_view(peer.data(), peer.size()));
    if (facts && Holds(*facts, *revoked_)) return true;
    spdlog::warn("audit: a certificate was refused, serial {}", facts ? facts->serial : "unread");
    *status = {grpc::StatusCode::UNAUTHENTICATED, "the certificate does not hold any more"};
    return true;
  }
  void Cancel(grpc::experimental::TlsCustomVerificationCheckRequest* /*request*/) override {}

 private:
  const std::shared_ptr<RevocationList> revoked_;
};

}  // namespace

void RequireCertificates(const fs::path& folder) {
  for (const char* file : {"ca.pem", "cert.pem", "key.pem"}) RequireFile(folder / file);
  RequirePrivate(folder / "key.pem");
  RequireUsable(folder);
}

std::optional<CertificateFacts> FactsOf(const grpc::AuthContext& context) {
  const auto found = context.FindPropertyValues(GRPC_X509_PEM_CERT_PROPERTY_NAME);
  if (found.empty()) return std::nullopt;
  return FactsOf(std::string_view(found[0].data(), found[0].size()));
}

std::shared_ptr<grpc::ServerCredentials> ServerTls(const fs::path& folder,
                                                   std::shared_ptr<RevocationList> revoked) {
  grpc::experimental::TlsServerCredentialsOptions options(Watched(folder));
  options.watch_root_certs();
  options.watch_identity_key_cert_pairs();
  options.set_cert_request_type(GRPC_SSL_REQUEST_AND_REQUIRE_CLIENT_CERTIFICATE_AND_VERIFY);
  options.set_certificate_verifier(
      grpc::experimental::ExternalCertificateVerifier::Create<NotRevoked>(std::move(revoked)));
  return grpc::experimental::TlsServerCredentials(options);
}

std::shared_ptr<grpc::ChannelCredentials> ChannelTls(const fs::path& folder) {
  const auto provider = Watched(folder);  // options that nobody gets are never freed
  grpc::experimental::TlsChannelCredentialsOptions options;
  options.set_certificate_provider(provider);
  options.watch_root_certs();
  options.watch_identity_key_cert_pairs();
  return grpc::experimental::TlsCredentials(options);
}

}  // namespace palpate
