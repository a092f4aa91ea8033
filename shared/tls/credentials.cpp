#include "shared/tls/credentials.h"

#include <array>
#include <cstdlib>
#include <ctime>
#include <fstream>
#include <iterator>
#include <stdexcept>
#include <string>
#include <utility>

#include <grpcpp/security/tls_certificate_provider.h>
#include <grpcpp/security/tls_credentials_options.h>
#include <openssl/bio.h>
#include <openssl/pem.h>
#include <openssl/x509.h>

namespace palpate {
namespace {

namespace fs = std::filesystem;

constexpr unsigned kRefresh = 1;  // [s]

void RequireFile(const fs::path& file) {
  if (fs::is_regular_file(file)) return;
  throw std::invalid_argument(file.string() + " is missing: create it with deploy/certs");
}

void RequirePrivate(const fs::path& key) {
  const auto others = fs::perms::group_all | fs::perms::others_all;
  if ((fs::status(key).permissions() & others) == fs::perms::none) return;
  throw std::invalid_argument(key.string() + " is readable by other users: expected mode 0600");
}

// This gRPC has no setting for the minimum version. The only remaining cipher suite before 1.3
// needs a pre-shared secret, which does not exist.
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

template <auto kFree>
struct Freed {
  template <class T>
  void operator()(T* pointer) const {
    kFree(pointer);
  }
};
using Bio = std::unique_ptr<BIO, Freed<BIO_free>>;
using Certificate = std::unique_ptr<X509, Freed<X509_free>>;
using Key = std::unique_ptr<EVP_PKEY, Freed<EVP_PKEY_free>>;

// `text` must outlive the result.
Bio Reading(std::string_view text) {
  return Bio(BIO_new_mem_buf(text.data(), static_cast<int>(text.size())));
}

Certificate Read(std::string_view pem) {
  return Certificate(PEM_read_bio_X509(Reading(pem).get(), nullptr, nullptr, nullptr));
}

std::string Contents(const fs::path& file) {
  constexpr std::streamsize kMaxFileSize = 4 << 20;  // [bytes]
  std::ifstream stream(file, std::ios::binary);
  std::string text(kMaxFileSize, '\0');
  stream.read(text.data(), kMaxFileSize);
  text.resize(static_cast<std::size_t>(stream.gcount()));
  return text;
}

std::optional<WallTime> TimeIn(const ASN1_TIME* stated) {
  std::tm time{};
  if (ASN1_TIME_to_tm(stated, &time) != 1) return std::nullopt;
  return std::chrono::system_clock::from_time_t(timegm(&time));
}

std::string InWords(WallTime time) {
  const std::time_t seconds = std::chrono::system_clock::to_time_t(time);
  std::tm utc{};
  std::array<char, 32> text{};
  std::strftime(text.data(), text.size(), "%F %T UTC", gmtime_r(&seconds, &utc));
  return text.data();
}

}  // namespace

void RequireCertificates(const fs::path& folder) {
  for (const char* file : {"ca.pem", "cert.pem", "key.pem"}) RequireFile(folder / file);
  RequirePrivate(folder / "key.pem");
  RequireUsable(folder);
}

std::optional<WallTime> ExpiryOf(const grpc::AuthContext& context) {
  const auto found = context.FindPropertyValues(GRPC_X509_PEM_CERT_PROPERTY_NAME);
  if (found.empty()) return std::nullopt;
  return ExpiryOf(std::string_view(found[0].data(), found[0].size()));
}

std::shared_ptr<grpc::ServerCredentials> ServerTls(const fs::path& folder) {
  grpc::experimental::TlsServerCredentialsOptions options(Watched(folder));
  options.watch_root_certs();
  options.watch_identity_key_cert_pairs();
  options.set_cert_request_type(GRPC_SSL_REQUEST_AND_REQUIRE_CLIENT_CERTIFICATE_AND_VERIFY);
  return grpc::experimental::TlsServerCredentials(options);
}

std::shared_ptr<grpc::ChannelCredentials> ChannelTls(const fs::path& folder) {
  const auto provider = Watched(folder);  // options that are never used are never freed
  grpc::experimental::TlsChannelCredentialsOptions options;
  options.set_certificate_provider(provider);
  options.watch_root_certs();
  options.watch_identity_key_cert_pairs();
  return grpc::experimental::TlsCredentials(options);
}

std::optional<WallTime> ExpiryOf(std::string_view pem) {
  const Certificate certificate = Read(pem);
  return certificate ? TimeIn(X509_get0_notAfter(certificate.get())) : std::nullopt;
}

std::string WhyUntimely(const fs::path& folder, WallTime now) {
  for (const fs::path& file : {folder / "ca.pem", folder / "cert.pem"}) {
    const Certificate certificate = Read(Contents(file));
    if (!certificate) continue;
    const auto since = TimeIn(X509_get0_notBefore(certificate.get()));
    const auto until = TimeIn(X509_get0_notAfter(certificate.get()));
    if (until && now >= *until) {
      return file.string() + " expired on " + InWords(*until) +
             ": issue a new one with deploy/certs";
    }
    if (since && now < *since) {
      return file.string() + " is valid only from " + InWords(*since) +
             ", later than this machine's clock: set the clock";
    }
  }
  return {};
}

void RequireUsable(const fs::path& folder) {
  const fs::path ca = folder / "ca.pem", cert = folder / "cert.pem", key = folder / "key.pem";
  if (!Read(Contents(ca))) throw std::invalid_argument(ca.string() + " contains no certificate");
  const Certificate ours = Read(Contents(cert));
  if (!ours) throw std::invalid_argument(cert.string() + " contains no certificate");
  const auto no_password = [](char*, int, int, void*) { return 0; };
  const std::string text = Contents(key);
  const Key secret(PEM_read_bio_PrivateKey(Reading(text).get(), nullptr, no_password, nullptr));
  if (!secret) {
    throw std::invalid_argument(key.string() + " contains no key: expected one without a password");
  }
  if (X509_check_private_key(ours.get(), secret.get()) == 1) return;
  throw std::invalid_argument(key.string() + " is not the key of " + cert.string());
}

}  // namespace palpate
