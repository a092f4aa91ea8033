// The connection to the Haply inverse service on this machine: WebSocket and HTTP, each call with a
// time limit. Used by one thread.
#pragma once

#include <chrono>
#include <cstdint>
#include <memory>
#include <optional>
#include <string>

namespace palpate {

class HaplyLine {
 public:
  explicit HaplyLine(std::uint16_t port);
  ~HaplyLine();

  // The body of an answer to GET `path`; nullopt: no answer.
  std::optional<std::string> Get(const std::string& path, std::chrono::milliseconds limit) const;
  // Opens the WebSocket. Returns false if there is no answer.
  bool Open(std::chrono::milliseconds limit);
  // Closes it without waiting. Idempotent.
  void Close();
  // Sends a text message. False: the service is gone.
  bool Send(const std::string& text, std::chrono::milliseconds limit);
  enum class Received : std::uint8_t { kMessage, kNothingYet, kClosed };
  // Waits for the next message. kNothingYet: call it again; no data is lost.
  Received Receive(std::chrono::milliseconds limit, std::string* text);

 private:
  struct Parts;
  const std::uint16_t port_;
  std::unique_ptr<Parts> parts_;
};

}  // namespace palpate
