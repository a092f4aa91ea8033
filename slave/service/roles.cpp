#include "slave/service/roles.h"

#include <algorithm>
#include <array>
#include <chrono>
#include <utility>

#include <spdlog/spdlog.h>

#include "shared/text/text.h"
#include "shared/tls/credentials.h"
#include "shared/wire/errors.h"

namespace palpate {
namespace {

constexpr std::string_view kScheme = "palpate://";
constexpr std::string_view kOurs = "/palpate.v1.Teleoperation/";
constexpr std::size_t kMaxNameLength = 64;  // [characters]

constexpr unsigned kOperator = 1, kObserver = 2, kSensor = 4, kArm = 8, kAdmin = 16;
constexpr unsigned kWatches = kOperator | kObserver | kAdmin;
constexpr unsigned kAnybody = kWatches | kSensor | kArm;

// In the order of the bits.
constexpr std::array<std::string_view, 5> kRoles{"operator", "observer", "sensor", "arm", "admin"};

struct Rule {
  std::string_view method;  // of ours
  unsigned roles;
  bool is_logged;
};
constexpr std::array<Rule, 22> kRules{{{"GetScene", kAnybody, false},
                                       {"GetStatus", kAnybody, false},
                                       {"Operate", kOperator, true},
                                       {"WatchState", kWatches, false},
                                       {"WatchMesh", kWatches, false},
                                       {"WatchPatch", kWatches, false},
                                       {"WatchTrace", kWatches, false},
                                       {"WatchImages", kWatches, false},
                                       {"SetModel", kOperator | kAdmin, true},
                                       {"SetParameters", kOperator | kAdmin, true},
                                       {"Reset", kOperator | kAdmin, true},
                                       {"ReinitializeTracking", kOperator | kAdmin, true},
                                       {"EvictOperator", kAdmin, true},
                                       {"Stop", kAnybody, true},
                                       {"FeedTactile", kSensor, true},
                                       {"FeedImages", kSensor, true},
                                       {"DriveTool", kArm, true},
                                       {"ProposeScene", kAdmin, true},
                                       {"UseScene", kAdmin, true},
                                       {"FindOutline", kAdmin, false},
                                       {"FindBoard", kAdmin, false}}};
constexpr std::string_view kHealth = "/grpc.health.v1.Health/";
constexpr std::string_view kReflection = "/grpc.reflection.v1alpha.ServerReflection/";

unsigned RoleOf(std::string_view name) {
  const auto* found = std::ranges::find(kRoles, name);
  return found == kRoles.end() ? 0 : 1U << (found - kRoles.begin());
}

Rule RuleOf(std::string_view path) {
  if (path.starts_with(kHealth)) return {"", kAnybody, false};
  if (path.starts_with(kReflection)) return {"", kAdmin, false};
  if (!path.starts_with(kOurs)) return {"", 0, false};
  const auto* found = std::ranges::find(kRules, path.substr(kOurs.size()), &Rule::method);
  return found == kRules.end() ? Rule{"", 0, false} : *found;
}

class Processor final : public grpc::AuthMetadataProcessor {
 public:
  bool IsBlocking() const override { return false; }
  grpc::Status Process(const InputMetadata& metadata, grpc::AuthContext* context,
                       OutputMetadata* /*consumed*/, OutputMetadata* /*response*/) override {
    const auto found = metadata.find(":path");
    const std::string path =
        found == metadata.end() ? "" : std::string(found->second.data(), found->second.size());
    const Identity who = IdentityOf(*context);
    const std::string method = Presentable(path, kMaxNameLength);
    const auto expiry = ExpiryOf(*context);
    if (!expiry || std::chrono::system_clock::now() >= *expiry) {
      spdlog::warn("audit: {} {} was rejected: no valid certificate", who.role, who.name);
      return Error(v1::ERROR_REASON_CERTIFICATE_INVALID, "the certificate is no longer valid");
    }
    if (!MayCall(who.role, path)) {
      spdlog::warn("audit: {} {} was rejected: {}", who.role, who.name, method);
      return Error(v1::ERROR_REASON_ROLE_NOT_ALLOWED,
                   "role '" + who.role + "' may not call " + method +
                       ": expected the calls of its role, see proto/README.md");
    }
    if (RuleOf(path).is_logged) spdlog::info("audit: {} {} called {}", who.role, who.name, method);
    return grpc::Status::OK;
  }
};

}  // namespace

Identity ParseIdentity(std::string_view alternative_name) {
  if (!alternative_name.starts_with(kScheme)) return {};
  alternative_name.remove_prefix(kScheme.size());
  const auto slash = alternative_name.find('/');
  if (slash == std::string_view::npos) return {};
  const std::string_view role = alternative_name.substr(0, slash);
  std::string name = Presentable(alternative_name.substr(slash + 1), kMaxNameLength);
  if (RoleOf(role) == 0 || name.empty()) return {};
  return {std::string(role), std::move(name)};
}

Identity IdentityOf(const grpc::AuthContext& context) {
  for (const auto& name : context.FindPropertyValues(GRPC_X509_SAN_PROPERTY_NAME)) {
    const Identity identity = ParseIdentity({name.data(), name.size()});
    if (!identity.role.empty()) return identity;
  }
  return {};
}

std::optional<std::string> OperatorNameOf(const grpc::ServerContextBase& context) {
  const auto authenticated = context.auth_context();
  if (authenticated->IsPeerAuthenticated()) {
    const Identity identity = IdentityOf(*authenticated);
    return identity.role == "operator" ? std::optional(identity.name) : std::nullopt;
  }
  const auto found = context.client_metadata().find(kOperatorMetadata);
  if (found == context.client_metadata().end()) return std::nullopt;
  return Presentable({found->second.data(), found->second.size()}, kMaxNameLength);
}

std::string ClientOf(const grpc::ServerContextBase& context) {
  const Identity identity = IdentityOf(*context.auth_context());
  if (identity.role.empty()) return context.peer();
  return identity.role + " " + identity.name + " (" + context.peer() + ")";
}

bool MayCall(std::string_view role, std::string_view path) {
  return (RuleOf(path).roles & RoleOf(role)) != 0;
}

std::shared_ptr<grpc::AuthMetadataProcessor> RoleCheck() {
  return std::make_shared<Processor>();
}

}  // namespace palpate
