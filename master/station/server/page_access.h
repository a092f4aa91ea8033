// Access to the page from other machines: TLS with a certificate for this host, and a token that is
// created at each start and printed in the terminal.
#pragma once

#include <filesystem>
#include <memory>
#include <string>
#include <string_view>

#include <boost/asio/ssl/context.hpp>

#include "shared/link/loopback.h"

namespace palpate {

struct PageAccess {
  std::shared_ptr<boost::asio::ssl::context> tls;  // null: plain text on loopback
  std::string token = {};                          // 128 bits in hexadecimal digits
  // Of the certificate.
  std::filesystem::path folder = {};
  std::string host = {};
  std::filesystem::file_time_type written_at = {};
};

// Address and access of a page.
struct PagePlace {
  Endpoint endpoint;  // port 0: a free one
  PageAccess access;
};

// Returns the address of `--view HOST:PORT`; empty: 127.0.0.1 and a free port. An address beyond
// loopback needs the certificate of `tls`. Throws std::invalid_argument otherwise, and like
// MakePageAccess.
PagePlace ViewPlace(const std::string& text, const std::filesystem::path& tls);

// Access to a page at `host` with the certificate of `folder` (--tls). Throws std::invalid_argument
// if a file is missing or unreadable, others can read the key, or the certificate does not fit the
// host.
PageAccess MakePageAccess(const std::filesystem::path& folder, const std::string& host);
// Reads the certificate again if its file has changed. One that cannot be used is left out.
void RenewCertificate(PageAccess* access);

// Returns whether the query of the request `target` is the token (`/ws?token=...`). Runs in
// constant time.
bool CarriesToken(std::string_view target, std::string_view token);

// Checks of HTTP requests to the page, against requests that another web site makes the browser
// send.
//
// Accepts a Host header that names this machine: a loopback address or `localhost`, with any port,
// as through a tunnel. Other names indicate DNS rebinding. Returns the reason of a rejection, else
// an empty string.
std::string RefusalOfHost(std::string_view host);
// Accepts an Origin header of the page itself, or none, as from a program. `scheme`: `http://` or
// `https://`. Returns the reason of a rejection, else an empty string.
std::string RefusalOfOrigin(std::string_view origin, std::string_view host,
                            std::string_view scheme);

}  // namespace palpate
