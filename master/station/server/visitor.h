// Checks of HTTP requests to the page, against requests that another web site makes the browser
// send.
#pragma once

#include <string>
#include <string_view>

namespace palpate {

// Accepts a Host header that names this machine: a loopback address or `localhost`, with any port,
// as through a tunnel. Other names indicate DNS rebinding. Returns the reason of a rejection, else
// an empty string.
std::string RefusalOfHost(std::string_view host);
// Accepts an Origin header of the page itself, or none, as from a program. `scheme`: `http://` or
// `https://`. Returns the reason of a rejection, else an empty string.
std::string RefusalOfOrigin(std::string_view origin, std::string_view host,
                            std::string_view scheme);

}  // namespace palpate
