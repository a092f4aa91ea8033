// Mutual TLS 1.3 from a folder of deploy/certs: `ca.pem` is the trusted CA, `cert.pem` and
// `key.pem` the own identity. Replaced files apply to new connections without a restart.
#pragma once

#include <chrono>
#include <filesystem>
#include <memory>
#include <mutex>
#include <optional>
#include <string>
#include <string_view>

#include <grpcpp/security/auth_context.h>
#include <grpcpp/security/credentials.h>
#include <grpcpp/security/server_credentials.h>

#include "shared/link/priority_inheritance_mutex.h"

namespace palpate {

// Validity period and revocation of certificates.
using WallTime = std::chrono::system_clock::time_point;

// `serial`: serial number in hexadecimal digits.
struct CertificateFacts {
  std::string serial;
  WallTime until{};  // expiry
};
// Facts of the first certificate in `pem`; nullopt: none.
std::optional<CertificateFacts> FactsOf(std::string_view pem);

// Throws std::invalid_argument with the unusable file of `folder`: `ca.pem` or `cert.pem` without a
// certificate, or a `key.pem` that is no key or does not match.
void RequireUsable(const std::filesystem::path& folder);

// Text if `ca.pem` or `cert.pem` in `folder` has expired or is not valid yet at `now`, with the
// next step; empty: both are valid.
std::string WhyUntimely(const std::filesystem::path& folder,
                        WallTime now = std::chrono::system_clock::now());

// The revocation list `crl.pem` of a folder, signed by its `ca.pem`. Without it nothing is revoked.
// It is read again at most once a second. An unusable new file leaves the list unchanged and is
// logged. Thread-safe.
class RevocationList {
 public:
  // Throws std::invalid_argument if the file is no such list.
  explicit RevocationList(std::filesystem::path folder);
  ~RevocationList();
  [[nodiscard]] bool Names(const std::string& serial);

 private:
  struct List;

  void Refresh();

  const std::filesystem::path file_, ca_;
  PriorityInheritanceMutex mutex_;  // guards what follows
  std::chrono::steady_clock::time_point looked_at_{};
  std::filesystem::file_time_type written_at_{};
  std::unique_ptr<List> list_;  // null: no list
};

// Whether `certificate` is valid and not revoked at `now`.
bool Holds(const CertificateFacts& certificate, RevocationList& revoked,
           WallTime now = std::chrono::system_clock::now());

// Throws std::invalid_argument if a file is missing, or others can read the key.
void RequireCertificates(const std::filesystem::path& folder);

// Both functions throw std::invalid_argument if a file is missing, or others can read the key. Call
// them before other functions of gRPC.
//
// Clients need a certificate of the same CA that is not in `revoked`.
std::shared_ptr<grpc::ServerCredentials> ServerTls(const std::filesystem::path& folder,
                                                   std::shared_ptr<RevocationList> revoked);
// The slave needs a certificate of the same CA for the requested host.
std::shared_ptr<grpc::ChannelCredentials> ChannelTls(const std::filesystem::path& folder);

// Certificate of the peer of a call; nullopt: plain text.
std::optional<CertificateFacts> FactsOf(const grpc::AuthContext& context);

}  // namespace palpate
