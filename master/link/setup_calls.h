// The calls of the slave's set-up, as JSON with the field names of setup.proto, for the page. They
// use a connection of their own and take seconds.
#pragma once

#include <memory>
#include <stop_token>
#include <string>
#include <string_view>

#include "master/link/slave_link.h"

namespace palpate {

class SetupCalls {
 public:
  struct Answer {
    int status = 200;  // of HTTP: 200, 400 (request), 403, 409 (not now) or 502 (no answer)
    // The reply; or {"error": text, "reason": name of an ErrorReason without its prefix, "code":
    // DEADLINE_EXCEEDED, UNAVAILABLE, PERMISSION_DENIED or UNAUTHENTICATED}, of which the last two
    // may be absent.
    std::string json;
  };

  // Throws std::invalid_argument for an invalid target, or one beyond loopback without `insecure`.
  explicit SetupCalls(const SlaveLink::Options& link);
  ~SetupCalls();

  // Makes the call `name`: `propose`, `use`, `outline`, `board`, or `image` for the newest image
  // without overlays. `stop` cancels it. Thread-safe.
  [[nodiscard]] Answer Make(std::string_view name, const std::string& json,
                            const std::stop_token& stop) const;

 private:
  struct Parts;
  std::unique_ptr<Parts> parts_;
};

// The answer to a request that is rejected: `why` in the form of Answer::json.
std::string SetupErrorJson(std::string_view why);

}  // namespace palpate
