// Mutual TLS 1.3 from a folder of deploy/certs: `ca.pem` is the trusted CA, `cert.pem` and
// `key.pem` the own identity. Replaced files apply to new connections without a restart.
#pragma once

#include <filesystem>
#include <memory>
#include <optional>

#include <grpcpp/security/auth_context.h>
#include <grpcpp/security/credentials.h>
#include <grpcpp/security/server_credentials.h>

#include "shared/tls/certificate.h"

namespace palpate {

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
