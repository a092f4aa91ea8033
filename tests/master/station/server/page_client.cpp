#include "tests/master/station/server/page_client.h"

#include <array>
#include <stdexcept>
#include <utility>

#include <arpa/inet.h>
#include <netinet/in.h>
#include <netinet/tcp.h>
#include <sys/socket.h>
#include <sys/time.h>
#include <unistd.h>

namespace palpate {

PageClient::PageClient(const Endpoint& server, const Window& window)
    : socket_(socket(AF_INET, SOCK_STREAM, 0)) {
  const timeval timeout{30, 0};
  setsockopt(socket_, SOL_SOCKET, SO_RCVTIMEO, &timeout, sizeof timeout);
  setsockopt(socket_, SOL_SOCKET, SO_SNDTIMEO, &timeout, sizeof timeout);
  const auto set = [this](int level, int name, int value) {
    if (value > 0) setsockopt(socket_, level, name, &value, sizeof value);
  };
  set(SOL_SOCKET, SO_RCVBUF, window.receive_buffer);
  set(IPPROTO_TCP, TCP_MAXSEG, window.largest_segment);
  sockaddr_in at{};
  at.sin_family = AF_INET;
  at.sin_port = htons(server.port);
  at.sin_addr.s_addr = htonl(INADDR_LOOPBACK);
  if (connect(socket_, reinterpret_cast<const sockaddr*>(&at), sizeof at) != 0) {
    close(socket_);
    throw std::runtime_error("nobody listens");
  }
}

PageClient::~PageClient() {
  close(socket_);
}

bool PageClient::Send(std::string_view bytes) {
  while (!bytes.empty()) {
    const ssize_t sent = send(socket_, bytes.data(), bytes.size(), MSG_NOSIGNAL);
    if (sent <= 0) return false;
    bytes.remove_prefix(static_cast<std::size_t>(sent));
  }
  return true;
}

bool PageClient::Fill() {
  std::array<char, 65536> buffer{};
  const ssize_t size = recv(socket_, buffer.data(), buffer.size(), 0);
  if (size <= 0) return false;
  received_.append(buffer.data(), static_cast<std::size_t>(size));
  return true;
}

std::string PageClient::ReadAll() {
  while (Fill()) {
  }
  return std::exchange(received_, {});
}

std::string PageClient::ReadUntil(std::string_view end) {
  std::size_t at = 0;
  while ((at = received_.find(end)) == std::string::npos) {
    if (!Fill()) return std::exchange(received_, {});
  }
  std::string text = received_.substr(0, at + end.size());
  received_.erase(0, at + end.size());
  return text;
}

std::string PageClient::Upgrade(const std::string& host, const std::string& origin,
                                const std::string& target) {
  std::string request =
      "GET " + target + " HTTP/1.1\r\nUpgrade: websocket\r\nConnection: Upgrade\r\n";
  request += "Sec-WebSocket-Version: 13\r\nSec-WebSocket-Key: AAAAAAAAAAAAAAAAAAAAAA==\r\n";
  if (!host.empty()) request += "Host: " + host + "\r\n";
  if (!origin.empty()) request += "Origin: " + origin + "\r\n";
  Send(request + "\r\n");
  const std::string answer = ReadUntil("\r\n\r\n");
  return answer.substr(0, answer.find("\r\n"));
}

std::optional<PageClient::Frame> PageClient::ReadFrame() {
  const auto need = [this](std::size_t size) {
    while (received_.size() < size) {
      if (!Fill()) return false;
    }
    return true;
  };
  const auto byte = [this](std::size_t i) { return static_cast<std::uint8_t>(received_[i]); };
  if (!need(2)) return std::nullopt;
  std::size_t size = byte(1) & 0x7f, head = 2;
  const std::size_t more = size == 126 ? 2 : size == 127 ? 8 : 0;
  if (!need(head + more)) return std::nullopt;
  if (more > 0) size = 0;
  for (std::size_t i = 0; i < more; ++i) size = size << 8 | byte(head + i);
  head += more;
  if (!need(head + size)) return std::nullopt;
  Frame frame{byte(0) & 0x0f, received_.substr(head, size)};
  const bool is_whole = (byte(0) & 0x80) != 0;
  received_.erase(0, head + size);
  if (is_whole) return frame;
  const auto rest = ReadFrame();  // long messages come in parts
  if (!rest) return std::nullopt;
  frame.payload += rest->payload;
  return frame;
}

std::optional<PageClient::Frame> PageClient::ReadFrame(int opcode) {
  while (auto frame = ReadFrame()) {
    if (frame->opcode == opcode) return frame;
  }
  return std::nullopt;
}

bool PageClient::SendFrame(char kind, std::string_view text) {
  std::string frame(1, kind);
  if (text.size() < 126) {
    frame += static_cast<char>(0x80 | text.size());
  } else {
    frame += static_cast<char>(0x80 | 126);
    frame += static_cast<char>(text.size() >> 8);
    frame += static_cast<char>(text.size() & 0xff);
  }
  frame.append(4, '\0');  // a mask of zeros does not change the text
  return Send(frame.append(text));
}

}  // namespace palpate
