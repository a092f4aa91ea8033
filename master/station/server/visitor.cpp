#include "master/station/server/visitor.h"

#include <stdexcept>

#include "shared/link/loopback.h"
#include "shared/text/text.h"

namespace palpate {
namespace {

// Without its port, which a browser leaves out where it is 80.
bool NamesThisMachine(std::string_view host) {
  const std::string with_port(host);
  for (const std::string& address : {with_port, with_port + ":80"}) {
    try {
      return IsLoopback(ParseEndpoint(address).host);
    } catch (const std::invalid_argument&) {  // no port, or no address at all
    }
  }
  return false;
}

}  // namespace

std::string RefusalOfHost(std::string_view host) {
  if (NamesThisMachine(host)) return {};
  return "Host " + Shown(host) + ": accepted is this machine: 127.0.0.1, [::1] or localhost";
}

std::string RefusalOfOrigin(std::string_view origin, std::string_view host,
                            std::string_view scheme) {
  if (origin.empty() || origin == std::string(scheme).append(host)) return {};
  return "Origin " + Shown(origin) + ": accepted is the page itself";
}

}  // namespace palpate
