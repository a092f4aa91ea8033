#include "slave/simulator/program/tool_socket.h"

#include <cerrno>
#include <cstdio>
#include <system_error>

#include <arpa/inet.h>
#include <sys/socket.h>
#include <unistd.h>

namespace palpate {
namespace {

int OpenSocket() {
  const int made = socket(AF_INET, SOCK_DGRAM, 0);
  sockaddr_in here{};
  here.sin_family = AF_INET;
  here.sin_addr.s_addr = htonl(INADDR_LOOPBACK);
  if (made < 0 || bind(made, reinterpret_cast<sockaddr*>(&here), sizeof here) != 0) {
    throw std::system_error(errno, std::generic_category(), "UDP on 127.0.0.1");
  }
  const timeval timeout{0, 100'000};  // 0.1 s, after which the thread may end
  setsockopt(made, SOL_SOCKET, SO_RCVTIMEO, &timeout, sizeof timeout);
  return made;
}

}  // namespace

ToolSocket::ToolSocket(SimulatedEnvironment& environment)
    : environment_(environment), socket_(OpenSocket()) {
  thread_ = std::jthread([this](const std::stop_token& stop) {
    while (!stop.stop_requested()) Answer();
  });
}

ToolSocket::~ToolSocket() {
  thread_ = {};
  close(socket_);
}

std::string ToolSocket::address() const {
  sockaddr_in here{};
  socklen_t size = sizeof here;
  getsockname(socket_, reinterpret_cast<sockaddr*>(&here), &size);
  return "127.0.0.1:" + std::to_string(ntohs(here.sin_port));
}

void ToolSocket::Answer() {
  char text[200] = "";
  sockaddr_in from{};
  socklen_t size = sizeof from;
  auto* const sender = reinterpret_cast<sockaddr*>(&from);
  const auto got = recvfrom(socket_, text, sizeof text - 1, 0, sender, &size);
  Eigen::Vector3d p_S(0, 0, 0);
  if (got <= 0 || std::sscanf(text, "%lf %lf %lf", &p_S.x(), &p_S.y(), &p_S.z()) != 3) return;
  environment_.MoveTool(p_S, WhenUnsolved::kUseNearest);
  const Truth truth = environment_.truth();
  if (!truth.solved) return;
  const int length = std::snprintf(text, sizeof text, "%.9g %.9g %.9g", truth.force.x(),
                                   truth.force.y(), truth.force.z());
  sendto(socket_, text, static_cast<std::size_t>(length), 0, sender, size);
}

}  // namespace palpate
