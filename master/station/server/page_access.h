// Who reaches the page from elsewhere: TLS with a certificate for this host, and a token that is
// made anew at each start and known to whoever reads the terminal.
#pragma once

#include <filesystem>
#include <memory>
#include <string>
#include <string_view>

#include <boost/asio/ssl/context.hpp>

#include "shared/link/loopback.h"

namespace palpate {

struct PageAccess {
  std::shared_ptr<boost::asio::ssl::context> tls;  // null: plain text, for this machine
  std::string token = {};                          // 128 bits in hexadecimal digits
};

// Where a page is served, and to whom.
struct PagePlace {
  Endpoint endpoint;  // port 0: a free one
  PageAccess access;
};

// Of --view HOST:PORT; empty: 127.0.0.1 and a free port. Beyond this machine only with the
// certificate of `tls`. Throws std::invalid_argument: not understood, or beyond without; as
// MakePageAccess.
PagePlace ViewPlace(const std::string& text, const std::filesystem::path& tls);

// For a page at `host`, an address, with the certificate of `folder`, as --tls takes it. Throws
// std::invalid_argument: a file is missing or not readable, the key may be read by others, the
// certificate serves no page or not this host.
PageAccess MakePageAccess(const std::filesystem::path& folder, const std::string& host);

// `target`, of a request, carries the token: `/ws?token=...`. Takes as long whichever it carries.
bool CarriesToken(std::string_view target, std::string_view token);

}  // namespace palpate
