// Access control. The role comes from the certificate: the first subject alternative name
// `palpate://ROLE/NAME`.
#pragma once

#include <memory>
#include <string>
#include <string_view>

#include <grpcpp/security/auth_context.h>
#include <grpcpp/security/auth_metadata_processor.h>

#include "shared/tls/certificate.h"

namespace palpate {

struct Identity {
  std::string role, name;  // empty: none
};
// Role and name of `alternative_name`; empty unless it has this form.
Identity ParseIdentity(std::string_view alternative_name);
Identity IdentityOf(const grpc::AuthContext& context);

// `path`: /package.Service/Method. Unlisted methods are denied.
bool MayCall(std::string_view role, std::string_view path);

// Rejects calls that the table denies with PERMISSION_DENIED, and invalid certificates with
// UNAUTHENTICATED. Logs rejections and all calls that stop, operate or change something.
std::shared_ptr<grpc::AuthMetadataProcessor> RoleCheck(std::shared_ptr<RevocationList> revoked);

}  // namespace palpate
