// What a certificate says beside whom it names: how long it holds, and whether its CA took it back.
#pragma once

#include <chrono>
#include <filesystem>
#include <memory>
#include <mutex>
#include <optional>
#include <string>
#include <string_view>

namespace palpate {

using WallTime = std::chrono::system_clock::time_point;

// `serial` as the CA counts, in hexadecimal digits.
struct CertificateFacts {
  std::string serial;
  WallTime until{};  // it holds no longer
};
// Of the first certificate in `pem`; nullopt: none that can be read.
std::optional<CertificateFacts> FactsOf(std::string_view pem);

// Throws std::invalid_argument naming the file of `folder` that cannot be used: `ca.pem` and
// `cert.pem` without a certificate, a `key.pem` that is no key or that of another certificate.
void RequireUsable(const std::filesystem::path& folder);

// What of `ca.pem` and `cert.pem` in `folder`, which can be used, does not hold at `now`, and the
// way out, in words; empty: both hold.
std::string WhyUntimely(const std::filesystem::path& folder,
                        WallTime now = std::chrono::system_clock::now());

// `crl.pem` of a folder of certificates, signed by the `ca.pem` beside it. Without it nothing is
// revoked. Looked at anew at most once a second: what is replaced by something that cannot be used
// leaves the list as it was, with a line in the log. Thread-safe.
class RevocationList {
 public:
  // Throws std::invalid_argument: there is a file that is no such list.
  explicit RevocationList(std::filesystem::path folder);
  ~RevocationList();
  [[nodiscard]] bool Names(const std::string& serial);

 private:
  struct List;

  void Refresh();

  const std::filesystem::path file_, ca_;
  std::mutex mutex_;  // guards what follows
  std::chrono::steady_clock::time_point looked_at_{};
  std::filesystem::file_time_type written_at_{};
  std::unique_ptr<List> list_;  // null: nothing is revoked
};

// Whether it may be believed at `now`.
bool Holds(const CertificateFacts& certificate, RevocationList& revoked,
           WallTime now = std::chrono::system_clock::now());

}  // namespace palpate
