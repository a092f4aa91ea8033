// Serves the operator's page: HTTP for files, a WebSocket for messages. It has one thread of normal
// priority, and the haptic loop never waits for it. It uses Boost.Beast, which is header-only,
// packaged by Debian, and has limits per connection.
#pragma once

#include <cstdint>
#include <functional>
#include <memory>
#include <string>
#include <string_view>

#include "master/station/server/notice_board.h"
#include "master/station/server/page_access.h"
#include "shared/link/loopback.h"

namespace palpate {

class PageServer {
 public:
  static constexpr std::size_t kMaxPages = 8, kMaxConnections = 64;
  static constexpr int kMaxCommands = 500;  // per page and second
  // Body of a request of the set-up [bytes]: the 32 MiB of files that a slave accepts, in base64,
  // and the names of the files.
  static constexpr std::size_t kMaxSetupBytes = 44 << 20;
  // Bodies that arrive at the same time [bytes], by the lengths that their headers state.
  static constexpr std::size_t kMaxArriving = 64 << 20;

  // Events of pages. Called on the server's thread; must return at once.
  struct Listener {
    // A page sent `message`. Returns the answer; empty: none. std::invalid_argument closes the page
    // with its text.
    std::function<std::string(std::uint64_t page, std::string_view message)> receive;
    std::function<void(std::uint64_t page)> left;
    // A request `POST /setup/CALL` with its body. `done` is called once, on any thread, with the
    // HTTP status and the answer in JSON. Empty: there is no set-up.
    using Done = std::function<void(int status, std::string json)>;
    std::function<void(std::string call, std::string json, Done done)> set_up = {};
  };

  // Listens at `endpoint`; port 0: a free one. `board` must outlive the server. `access`: TLS and
  // the token. Without TLS only pages of this machine are served. Throws std::runtime_error if the
  // address cannot be used.
  PageServer(const Endpoint& endpoint, const NoticeBoard* board, Listener listener,
             PageAccess access = {});
  // Closes every page.
  ~PageServer();

  [[nodiscard]] Endpoint endpoint() const;  // with the actual port
  // Returns the address to open: `http://HOST:PORT/`, or `https://HOST:PORT/#TOKEN`.
  [[nodiscard]] std::string address() const;
  [[nodiscard]] std::size_t pages() const;  // number of open pages; thread-safe
  // Announces a new message on the board. Thread-safe; returns at once.
  void Notify();

 private:
  struct Parts;
  std::unique_ptr<Parts> parts_;
};

}  // namespace palpate
