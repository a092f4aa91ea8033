// Who may look at the station's page and operate through it: browsers that were sent here by a
// person, not by a page of somebody else's.
#pragma once

#include <string>
#include <string_view>

namespace palpate {

// A request's Host names this machine: a loopback address or `localhost`, with any port, as through
// a tunnel. Another name leads here only where somebody has rebound it. Empty: it may pass, else
// why not.
std::string RefusalOfHost(std::string_view host);
// A request to operate comes from the page itself: its Origin is SCHEME HOST, or absent, as from a
// program. `scheme`: `http://` or `https://`. Empty: it may pass, else why not.
std::string RefusalOfOrigin(std::string_view origin, std::string_view host,
                            std::string_view scheme);

}  // namespace palpate
