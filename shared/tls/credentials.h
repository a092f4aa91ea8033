// Mutual TLS 1.3 from a folder, as deploy/certs makes it: `ca.pem`, whom to believe; `cert.pem` and
// `key.pem`, who we are. Files that are replaced count for the next connections, without a restart.
#pragma once

#include <filesystem>
#include <memory>

#include <grpcpp/security/credentials.h>
#include <grpcpp/security/server_credentials.h>

namespace palpate {

// Both throw std::invalid_argument: a file is missing, or the key may be read by others. Before
// anything else of gRPC is used.
//
// Whoever connects must show a certificate of the same CA.
std::shared_ptr<grpc::ServerCredentials> ServerTls(const std::filesystem::path& folder);
// The slave must show one, too, for the host that was asked for.
std::shared_ptr<grpc::ChannelCredentials> ChannelTls(const std::filesystem::path& folder);

}  // namespace palpate
