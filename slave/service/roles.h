// Who may call what. The role is the certificate's: a subject alternative name
// `palpate://ROLE/NAME`, the first there is.
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
// Of `alternative_name`; empty unless it is one of ours and names somebody.
Identity ParseIdentity(std::string_view alternative_name);
Identity IdentityOf(const grpc::AuthContext& context);

// `path`: /package.Service/Method. What the table does not know, nobody may call.
bool MayCall(std::string_view role, std::string_view path);

// Refuses with PERMISSION_DENIED what the table does not allow, with UNAUTHENTICATED whose
// certificate does not hold any more, and logs who stops, operates or changes something, and who
// was refused.
std::shared_ptr<grpc::AuthMetadataProcessor> RoleCheck(std::shared_ptr<RevocationList> revoked);

}  // namespace palpate
