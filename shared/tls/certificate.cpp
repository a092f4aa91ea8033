#include "shared/tls/certificate.h"

#include <array>
#include <ctime>
#include <fstream>
#include <iterator>
#include <set>
#include <stdexcept>
#include <utility>

#include <openssl/bio.h>
#include <openssl/bn.h>
#include <openssl/pem.h>
#include <openssl/x509.h>
#include <spdlog/spdlog.h>

namespace palpate {
namespace {

namespace fs = std::filesystem;

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
using Crl = std::unique_ptr<X509_CRL, Freed<X509_CRL_free>>;

// `text` outlives it.
Bio Reading(std::string_view text) {
  return Bio(BIO_new_mem_buf(text.data(), static_cast<int>(text.size())));
}

Certificate Read(std::string_view pem) {
  return Certificate(PEM_read_bio_X509(Reading(pem).get(), nullptr, nullptr, nullptr));
}

std::string SerialIn(const ASN1_INTEGER* number) {
  const std::unique_ptr<BIGNUM, Freed<BN_free>> big(ASN1_INTEGER_to_BN(number, nullptr));
  char* const digits = big ? BN_bn2hex(big.get()) : nullptr;
  std::string serial = digits != nullptr ? digits : "";
  OPENSSL_free(digits);
  return serial;
}

std::string Contents(const fs::path& file) {
  constexpr std::streamsize kLargest = 4 << 20;  // [bytes]
  std::ifstream stream(file, std::ios::binary);
  std::string text(kLargest, '\0');
  stream.read(text.data(), kLargest);
  text.resize(static_cast<std::size_t>(stream.gcount()));
  return text;
}

std::optional<WallTime> TimeIn(const ASN1_TIME* told) {
  std::tm time{};
  if (ASN1_TIME_to_tm(told, &time) != 1) return std::nullopt;
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

std::optional<CertificateFacts> FactsOf(std::string_view pem) {
  const Certificate certificate = Read(pem);
  const auto until = certificate ? TimeIn(X509_get0_notAfter(certificate.get())) : std::nullopt;
  if (!until) return std::nullopt;
  return CertificateFacts{SerialIn(X509_get0_serialNumber(certificate.get())), *until};
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
    throw std::invalid_argument(key.string() +
                                " contains no key: accepted is one without a password");
  }
  if (X509_check_private_key(ours.get(), secret.get()) == 1) return;
  throw std::invalid_argument(key.string() + " is not the key of " + cert.string());
}

struct RevocationList::List {
  // Throws std::invalid_argument.
  List(const fs::path& file, const fs::path& ca) {
    const Crl crl(PEM_read_bio_X509_CRL(Reading(Contents(file)).get(), nullptr, nullptr, nullptr));
    const Certificate issuer = Read(Contents(ca));
    if (!crl || !issuer || X509_CRL_verify(crl.get(), X509_get0_pubkey(issuer.get())) != 1) {
      throw std::invalid_argument(file.string() +
                                  ": accepted is a list of revoked certificates in PEM, signed by "
                                  "the ca.pem beside it (deploy/certs revoke)");
    }
    const STACK_OF(X509_REVOKED)* const revoked = X509_CRL_get_REVOKED(crl.get());
    for (int i = 0; i < sk_X509_REVOKED_num(revoked); ++i) {
      serials.insert(SerialIn(X509_REVOKED_get0_serialNumber(sk_X509_REVOKED_value(revoked, i))));
    }
  }
  std::set<std::string> serials;
};

RevocationList::RevocationList(fs::path folder)
    : file_(folder / "crl.pem"), ca_(std::move(folder) / "ca.pem") {
  if (!fs::exists(file_)) return;
  written_at_ = fs::last_write_time(file_);
  list_ = std::make_unique<List>(file_, ca_);
}

RevocationList::~RevocationList() = default;

bool RevocationList::Names(const std::string& serial) {
  const std::scoped_lock lock(mutex_);
  Refresh();
  return list_ != nullptr && list_->serials.contains(serial);
}

void RevocationList::Refresh() {
  const auto now = std::chrono::steady_clock::now();
  if (now - looked_at_ < std::chrono::seconds(1)) return;
  looked_at_ = now;
  try {
    std::error_code missing;
    const auto written_at = fs::last_write_time(file_, missing);
    if (missing || written_at == written_at_) return;  // who was revoked stays so
    written_at_ = written_at;
    list_ = std::make_unique<List>(file_, ca_);
  } catch (const std::exception& error) {
    spdlog::error("audit: the list of revoked certificates is unchanged: {}", error.what());
  }
}

bool Holds(const CertificateFacts& certificate, RevocationList& revoked, WallTime now) {
  return now < certificate.until && !revoked.Names(certificate.serial);
}

}  // namespace palpate
