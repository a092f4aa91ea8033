// Mutual TLS 1.3 from a folder of deploy/certs: `ca.pem` is the trusted CA, `cert.pem` and
// `key.pem` the own identity. Replaced files apply to new connections without a restart.
#pragma once

#include <chrono>
#include <filesystem>
#include <memory>
#include <optional>
#include <string>
#include <string_view>

#include <grpcpp/security/auth_context.h>
#include <grpcpp/security/credentials.h>
#include <grpcpp/security/server_credentials.h>

namespace palpate {

using WallTime = std::chrono::system_clock::time_point;

// Expiry of the first certificate in `pem`; nullopt: there is none.
std::optional<WallTime> ExpiryOf(std::string_view pem);

// Throws std::invalid_argument with the unusable file of `folder`: `ca.pem` or `cert.pem` without a
// certificate, or a `key.pem` that is no key or does not match.
void RequireUsable(const std::filesystem::path& folder);

// Text if `ca.pem` or `cert.pem` in `folder` has expired or is not valid yet at `now`, with the
// next step; empty: both are valid.
std::string WhyUntimely(const std::filesystem::path& folder,
                        WallTime now = std::chrono::system_clock::now());

// Throws std::invalid_argument if a file is missing, or others can read the key.
void RequireCertificates(const std::filesystem::path& folder);

// Both functions throw std::invalid_argument if a file is missing, or others can read the key. Call
// them before other functions of gRPC.
//
// Clients need a certificate of the same CA.
std::shared_ptr<grpc::ServerCredentials> ServerTls(const std::filesystem::path& folder);
// The slave needs a certificate of the same CA for the requested host.
std::shared_ptr<grpc::ChannelCredentials> ChannelTls(const std::filesystem::path& folder);

// Expiry of the certificate of the peer of a call; nullopt: plain text.
std::optional<WallTime> ExpiryOf(const grpc::AuthContext& context);

}  // namespace palpate
