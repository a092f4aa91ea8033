// Serves the station's page and speaks with those who look at it: HTTP for its files, a WebSocket
// for what moves. One thread of normal priority; the haptic loop never waits for it. Boost.Beast,
// because Debian packages it, it needs nothing but headers, and its limits are per connection.
#pragma once

#include <cstdint>
#include <functional>
#include <memory>
#include <string>
#include <string_view>

#include "master/station/notice_board.h"
#include "master/station/server/page_access.h"
#include "shared/link/loopback.h"

namespace palpate {

class PageServer {
 public:
  static constexpr std::size_t kMostPages = 8, kMostConnections = 64;
  static constexpr int kMostCommands = 500;  // of a page in a second

  // What pages do. Called by the server's thread, must return at once.
  struct Listener {
    // A page sent `message`. What to answer; empty: nothing. std::invalid_argument closes that page
    // with its words.
    std::function<std::string(std::uint64_t page, std::string_view message)> hear;
    std::function<void(std::uint64_t page)> left;
  };

  // Listens at `endpoint`, port 0: a free one. `board` outlives the server. `access`: TLS, and the
  // token that a page must carry; without TLS pages of this machine alone are answered. Throws
  // std::runtime_error: it cannot be listened there.
  PageServer(const Endpoint& endpoint, const NoticeBoard* board, Listener listener,
             PageAccess access = {});
  // Says goodbye to every page.
  ~PageServer();

  [[nodiscard]] Endpoint endpoint() const;  // with the port that was found
  // What a person opens: `http://HOST:PORT/`, or `https://HOST:PORT/#TOKEN`.
  [[nodiscard]] std::string address() const;
  [[nodiscard]] std::size_t pages() const;  // that look at this moment; thread-safe
  // The board has something new. Any thread; returns at once.
  void Notify();

 private:
  struct Parts;
  std::unique_ptr<Parts> parts_;
};

}  // namespace palpate
