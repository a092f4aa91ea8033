#include "master/station/server/page_access.h"

#include <algorithm>
#include <array>
#include <stdexcept>

#include <openssl/crypto.h>
#include <openssl/rand.h>
#include <openssl/ssl.h>
#include <openssl/x509v3.h>

#include "shared/link/loopback.h"
#include "shared/text/text.h"
#include "shared/tls/credentials.h"

namespace palpate {
namespace {

namespace ssl = boost::asio::ssl;

constexpr std::string_view kQuery = "?token=";

std::string MakeToken() {
  std::array<unsigned char, 16> random{};
  if (RAND_bytes(random.data(), static_cast<int>(random.size())) != 1) {
    throw std::runtime_error("--view: no random numbers for a token");
  }
  constexpr std::string_view kDigits = "0123456789abcdef";
  std::string token;
  for (const unsigned char byte : random) {
    token += kDigits[byte >> 4U];
    token += kDigits[byte & 15U];
  }
  return token;
}

// For 0.0.0.0 the names by which the page is reached are unknown, so any certificate is accepted.
bool IsForHost(X509* certificate, const std::string& host) {
  return host == "0.0.0.0" || host == "::" || X509_check_ip_asc(certificate, host.c_str(), 0) == 1;
}

void RequireForPage(ssl::context* tls, const std::filesystem::path& file, const std::string& host) {
  X509* const certificate = SSL_CTX_get0_certificate(tls->native_handle());
  const bool serves = X509_check_purpose(certificate, X509_PURPOSE_SSL_SERVER, 0) == 1;
  if (serves && IsForHost(certificate, host)) return;
  throw std::invalid_argument(file.string() + ": no certificate for a page at " + host +
                              ": expected one of `deploy/certs operator CA OUT NAME " + host + "`");
}

// Ignores the port, which a browser omits if it is 80.
bool NamesThisMachine(std::string_view host) {
  const std::string with_port(host);
  for (const std::string& address : {with_port, with_port + ":80"}) {
    try {
      return IsLoopback(ParseEndpoint(address).host);
    } catch (const std::invalid_argument&) {  // no port, or no address at all
    }
  }
  return false;
}

}  // namespace

PageAccess MakePageAccess(const std::filesystem::path& folder, const std::string& host) {
  RequireCertificates(folder);
  const auto written_at = std::filesystem::last_write_time(folder / "cert.pem");
  auto tls = std::make_shared<ssl::context>(ssl::context::tls_server);
  SSL_CTX_set_min_proto_version(tls->native_handle(), TLS1_3_VERSION);
  const auto cert = folder / "cert.pem", key = folder / "key.pem";
  try {
    tls->use_certificate_chain_file(cert.string());
    tls->use_private_key_file(key.string(), ssl::context::pem);
  } catch (const boost::system::system_error& error) {
    throw std::invalid_argument(cert.string() + " and key.pem: " + error.code().message());
  }
  RequireForPage(tls.get(), cert, host);
  return {std::move(tls), MakeToken(), folder, host, written_at};
}

void RenewCertificate(PageAccess* access) {
  if (!access->tls) return;
  std::error_code error;
  const auto written_at = std::filesystem::last_write_time(access->folder / "cert.pem", error);
  if (error || written_at == access->written_at) return;
  try {
    PageAccess renewed = MakePageAccess(access->folder, access->host);
    access->tls = std::move(renewed.tls);
    access->written_at = renewed.written_at;
  } catch (const std::exception&) {  // perhaps half written: the next connection tries again
  }
}

PagePlace ViewPlace(const std::string& text, const std::filesystem::path& tls) {
  const Endpoint endpoint = text.empty() ? Endpoint{"127.0.0.1", 0} : ParseEndpoint(text);
  if (IsLoopback(endpoint.host)) return {endpoint, {}};
  if (!tls.empty()) return {endpoint, MakePageAccess(tls, endpoint.host)};
  throw std::invalid_argument(
      "--view " + text +
      ": the page moves the tool, so beyond this machine it needs TLS: expected --tls DIR "
      "and a certificate for this host (deploy/certs operator), or a tunnel: "
      "ssh -L 8080:127.0.0.1:PORT");
}

bool CarriesToken(std::string_view target, std::string_view token) {
  target.remove_prefix(std::min(target.find('?'), target.size()));
  if (!target.starts_with(kQuery)) return false;
  target.remove_prefix(kQuery.size());
  return target.size() == token.size() &&
         CRYPTO_memcmp(target.data(), token.data(), token.size()) == 0;
}

std::string RefusalOfHost(std::string_view host) {
  if (NamesThisMachine(host)) return {};
  return "Host " + Shown(host) + ": expected this machine: 127.0.0.1, [::1] or localhost";
}

std::string RefusalOfOrigin(std::string_view origin, std::string_view host,
                            std::string_view scheme) {
  if (origin.empty() || origin == std::string(scheme).append(host)) return {};
  return "Origin " + Shown(origin) + ": expected the page itself";
}

}  // namespace palpate
