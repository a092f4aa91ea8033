// Access control. The role comes from the certificate: the first subject alternative name
// `palpate://ROLE/NAME`.
#pragma once

#include <memory>
#include <optional>
#include <string>
#include <string_view>

#include <grpcpp/security/auth_context.h>
#include <grpcpp/security/auth_metadata_processor.h>
#include <grpcpp/server_context.h>

namespace palpate {

struct Identity {
  std::string role, name;  // empty: none
};
// Role and name of `alternative_name`; empty unless it has this form.
Identity ParseIdentity(std::string_view alternative_name);
Identity IdentityOf(const grpc::AuthContext& context);

// Metadata of calls in plain text: the name of the operator that they belong to.
inline constexpr const char* kOperatorMetadata = "palpate-operator-bin";
// Name of an operator: from the certificate, or from the metadata in plain text. nullopt: none.
std::optional<std::string> OperatorNameOf(const grpc::ServerContextBase& context);
// For the log: role, name and address.
std::string ClientOf(const grpc::ServerContextBase& context);

// `path`: /package.Service/Method. Unlisted methods are denied.
bool MayCall(std::string_view role, std::string_view path);

// Rejects calls that the table denies with PERMISSION_DENIED, and invalid certificates with
// UNAUTHENTICATED. Logs rejections and all calls that stop, operate or change something.
std::shared_ptr<grpc::AuthMetadataProcessor> RoleCheck();

}  // namespace palpate
