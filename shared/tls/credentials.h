// Mutual TLS 1.3 from a folder, as deploy/certs makes it: `ca.pem`, whom to believe; `cert.pem` and
// `key.pem`, who we are. Files that are replaced count for the next connections, without a restart.
#pragma once

#include <filesystem>
#include <memory>
#include <optional>

#include <grpcpp/security/auth_context.h>
#include <grpcpp/security/credentials.h>
#include <grpcpp/security/server_credentials.h>

#include "shared/tls/certificate.h"

namespace palpate {

// Throws std::invalid_argument: one of the three is missing, or the key may be read by others.
void RequireCertificates(const std::filesystem::path& folder);

// Both throw std::invalid_argument: a file is missing, or the key may be read by others. Before
// anything else of gRPC is used.
//
// Whoever connects must show a certificate of the same CA that is not in `revoked`.
std::shared_ptr<grpc::ServerCredentials> ServerTls(const std::filesystem::path& folder,
                                                   std::shared_ptr<RevocationList> revoked);
// The slave must show one, too, for the host that was asked for.
std::shared_ptr<grpc::ChannelCredentials> ChannelTls(const std::filesystem::path& folder);

// Of the peer of a call; nullopt: plain text.
std::optional<CertificateFacts> FactsOf(const grpc::AuthContext& context);

}  // namespace palpate
