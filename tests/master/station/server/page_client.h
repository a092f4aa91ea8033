// The browser's side of a connection to the station. It works byte by byte, so that tests can also
// send data that no browser sends.
#pragma once

#include <optional>
#include <string>
#include <string_view>

#include "shared/link/loopback.h"

namespace palpate {

// Opcodes of WebSocket frames.
inline constexpr int kText = 1, kBinary = 2, kClose = 8;

// One TCP connection on loopback. Data that does not arrive within 30 s is considered missing.
class PageClient {
 public:
  // Size of the client's receive buffer; 0: the system's default.
  struct Window {
    int receive_buffer = 0;  // [bytes]
    // [bytes]. Loopback sends segments of 65 kB. A window that is smaller than one segment makes
    // progress only by the kernel's window probes, whose times differ between kernels.
    int largest_segment = 0;
  };
  // Throws std::runtime_error: refused.
  explicit PageClient(const Endpoint& server, const Window& window = {0, 0});
  ~PageClient();
  PageClient(const PageClient&) = delete;
  PageClient& operator=(const PageClient&) = delete;

  // False: the other end has closed.
  bool Send(std::string_view bytes);
  // Reads until the other end closes.
  std::string ReadAll();
  // Reads up to and including `end`, or until the other end closes.
  std::string ReadUntil(std::string_view end);

  // Performs the WebSocket handshake and returns the status line of the answer. Empty headers are
  // omitted.
  std::string Upgrade(const std::string& host, const std::string& origin,
                      const std::string& target = "/ws");
  struct Frame {
    int opcode = 0;  // 1 text, 2 binary, 8 close, 9 ping
    std::string payload;
    // The reason of a close frame, in words.
    [[nodiscard]] std::string reason() const { return payload.size() > 2 ? payload.substr(2) : ""; }
  };
  // nullopt: the line ended.
  std::optional<Frame> ReadFrame();
  // The first frame with `opcode`; nullopt: the line ended before.
  std::optional<Frame> ReadFrame(int opcode);
  // Masked as a browser's is.
  bool SendText(std::string_view text) { return SendFrame('\x81', text); }
  bool SendBinary(std::string_view bytes) { return SendFrame('\x82', bytes); }

 private:
  bool SendFrame(char kind, std::string_view content);
  bool Fill();

  int socket_;
  std::string received_;
};

}  // namespace palpate
