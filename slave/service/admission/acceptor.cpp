#include "slave/service/admission/acceptor.h"

#include <algorithm>
#include <cerrno>
#include <cmath>
#include <cstring>
#include <memory>
#include <stdexcept>
#include <utility>

#include <fcntl.h>
#include <linux/tcp.h>
#include <netdb.h>
#include <netinet/in.h>
#include <poll.h>
#include <spdlog/spdlog.h>
#include <sys/ioctl.h>
#include <sys/socket.h>
#include <unistd.h>

#include "shared/link/tcp_line.h"
#include "shared/link/thread_priority.h"

namespace palpate {
namespace {

constexpr std::chrono::milliseconds kCountPeriod(20);  // period of counting the received bytes
constexpr double kTrustPeriod = 1;                     // between two checks of certificates [s]
constexpr double kWindow = 0.2;  // time constant of the rate of a connection [s]
// Burst of a connection with its own rate, in time at that rate [s].
constexpr double kOwnBurst = 2;
// Time until the first byte must arrive, after which the system accepts the connection [s].
constexpr int kFirstByte = 3;
// Pause between two accepted connections: gRPC opens one in less than a millisecond, in the threads
// that also read the operator's commands.
constexpr std::chrono::milliseconds kBetween(1);
// Largest amount that a client sends before it has the server's settings [bytes]: the initial
// window of 65 535 bytes (RFC 9113, 6.9.2), and headers.
constexpr int kMaxUnread = 80 * 1024;
constexpr int kDescriptors = 4;          // for each connection; it uses two
constexpr std::size_t kLogEvery = 1000;  // closed connections per line of the log

void Set(int fd, int level, int option, int value) {
  setsockopt(fd, level, option, &value, sizeof value);
}

// Opens a listening socket at `address` and sets the port there. -1: see errno.
int Listen(sockaddr* address, socklen_t size) {
  const int fd = socket(address->sa_family, SOCK_STREAM | SOCK_CLOEXEC | SOCK_NONBLOCK, 0);
  if (fd < 0) return fd;
  Set(fd, SOL_SOCKET, SO_REUSEADDR, 1);  // reuses the port of a program that has ended
  Set(fd, IPPROTO_TCP, TCP_DEFER_ACCEPT, kFirstByte);
  if (address->sa_family == AF_INET6) Set(fd, IPPROTO_IPV6, IPV6_V6ONLY, 1);
  if (bind(fd, address, size) == 0 && listen(fd, SOMAXCONN) == 0) {
    getsockname(fd, address, &size);
    return fd;
  }
  const int error = errno;
  close(fd);
  errno = error;
  return -1;
}

// Fills in the port where it is 0.
std::vector<int> ListenAt(Endpoint* endpoint) {
  addrinfo hints{};
  hints.ai_socktype = SOCK_STREAM;
  hints.ai_flags = AI_PASSIVE;
  addrinfo* found = nullptr;
  const int unknown = getaddrinfo(endpoint->host.c_str(), nullptr, &hints, &found);
  const std::unique_ptr<addrinfo, decltype(&freeaddrinfo)> addresses(found, freeaddrinfo);
  std::vector<int> sockets;
  int error = 0;
  for (addrinfo* one = found; one != nullptr && error != EADDRINUSE; one = one->ai_next) {
    // The port is at the same place for both families.
    auto* address = reinterpret_cast<sockaddr_in6*>(one->ai_addr);
    address->sin6_port = htons(endpoint->port);
    const int fd = Listen(one->ai_addr, one->ai_addrlen);
    if (fd < 0) error = errno;
    if (fd < 0) continue;
    sockets.push_back(fd);
    endpoint->port = ntohs(address->sin6_port);
  }
  if (error != EADDRINUSE && !sockets.empty()) return sockets;
  for (const int fd : sockets) close(fd);
  throw std::runtime_error("cannot listen on " + ToString(*endpoint) + ": " +
                           (unknown != 0 ? gai_strerror(unknown) : std::strerror(error)));
}

struct Traffic {
  bool is_open;
  std::uint64_t received;  // [bytes] since the connection was opened
};

Traffic TrafficOf(int fd) {
  tcp_info info{};
  socklen_t size = sizeof info;
  getsockopt(fd, IPPROTO_TCP, TCP_INFO, &info, &size);
  constexpr int kEstablished = 1;  // TCP_ESTABLISHED of netinet/tcp.h, which excludes linux/tcp.h
  return {info.tcpi_state == kEstablished, info.tcpi_bytes_received};
}

}  // namespace

void Acceptor::Run(const std::stop_token& stop) {
  MakeThreadRealtime(kAdmissionPriority);
  std::vector<pollfd> polled;
  for (const int fd : listening_) polled.push_back({fd, POLLIN, 0});
  Time counted = Clock::now(), trust_checked{};
  while (!stop.stop_requested()) {
    // While too much data arrives, no new connection is accepted.
    const auto count = credit_ < 0 ? 0 : polled.size();
    const int ready = poll(polled.data(), count, static_cast<int>(kCountPeriod.count()));
    for (const pollfd& one : polled) {
      if (ready > 0 && one.revents != 0) AcceptOne(one.fd);
    }
    const Time now = Clock::now();
    if (now - counted >= kCountPeriod) {
      ApplyClients();
      CountBytes(SecondsBetween(std::exchange(counted, now), now));
    }
    if (SecondsBetween(trust_checked, now) >= kTrustPeriod) {
      CutUntrusted();
      trust_checked = now;
    }
    open_ = connections_.size();
  }
}

void Acceptor::AcceptOne(int listener) {
  sockaddr_storage peer{};
  socklen_t size = sizeof peer;
  const int fd =
      accept4(listener, reinterpret_cast<sockaddr*>(&peer), &size, SOCK_CLOEXEC | SOCK_NONBLOCK);
  if (fd < 0) return std::this_thread::sleep_for(kBetween);
  int unread = 0;
  if (ioctl(fd, FIONREAD, &unread) == 0 && unread > kMaxUnread) {
    return Close(fd, TurnedAway::kTooMuch);
  }
  if (connections_.size() >= limits_.connections) {
    const auto unused = std::ranges::find(connections_, false, &Connection::has_stream);
    if (unused == connections_.end()) return Close(fd, TurnedAway::kFull);
    Close(unused->fd, TurnedAway::kFull);
    connections_.erase(unused);
  }
  const int duplicate = fcntl(fd, F_DUPFD_CLOEXEC, 0);
  if (duplicate < 0) return Close(fd, TurnedAway::kFull);
  Set(fd, IPPROTO_TCP, TCP_NODELAY, 1);
  PrepareLine(fd);
  connections_.push_back({duplicate, NameOf(peer)});
  {
    const ReadingPriority calls_grpc;
    hand_on_(fd);
  }
  ++accepted_;
  std::this_thread::sleep_for(kBetween);
}

void Acceptor::ApplyClients() {
  const std::scoped_lock lock(mutex_);
  for (auto& [peer, client] : clients_) {
    const auto one = std::find_if(connections_.rbegin(), connections_.rend(),
                                  [&](const Connection& other) { return other.peer == peer; });
    if (one == connections_.rend()) continue;
    if (client.rate > one->rate) {
      one->rate = client.rate;
      one->own = kOwnBurst * client.rate;
    }
    one->trusted = std::move(client.trusted);
    one->has_stream = true;
  }
  clients_.clear();
}

// Closes the connections that send most, until the others are within half of the rate.
void Acceptor::CountBytes(double dt) {
  credit_ = std::min(limits_.burst, credit_ + limits_.rate * dt);
  double recent = 0;  // of all
  std::erase_if(connections_, [&](Connection& one) {
    const auto [is_open, total] = TrafficOf(one.fd);
    const auto received = static_cast<double>(total - std::exchange(one.received, total));
    one.own = std::min(kOwnBurst * one.rate, one.own + one.rate * dt);
    const double excess = std::max(0.0, received - one.own);
    one.own = std::max(0.0, one.own - received);
    one.recent = one.recent * std::exp(-dt / kWindow) + excess;
    credit_ -= excess;
    if (is_open) recent += one.recent;
    if (!is_open) close(one.fd);
    return !is_open;
  });
  while (credit_ < 0 && recent > limits_.rate * kWindow / 2) {
    const auto heaviest = std::ranges::max_element(connections_, {}, &Connection::recent);
    recent -= heaviest->recent;
    Close(heaviest->fd, TurnedAway::kTooMuch);
    connections_.erase(heaviest);
  }
  credit_ = std::max(credit_, -limits_.burst / 2);  // one burst closes the port only for a moment
}

void Acceptor::CutUntrusted() {
  std::erase_if(connections_, [this](const Connection& one) {
    if (!one.trusted || one.trusted()) return false;
    spdlog::warn("audit: {} was disconnected: its certificate is no longer valid", one.peer);
    Close(one.fd, TurnedAway::kUntrusted);
    return true;
  });
}

// Also discards unread data, if the system can do that.
void Acceptor::Close(int fd, TurnedAway why) {
  sockaddr nowhere{};
  nowhere.sa_family = AF_UNSPEC;
  if (connect(fd, &nowhere, sizeof nowhere) != 0) shutdown(fd, SHUT_RDWR);
  close(fd);
  const auto index = static_cast<std::size_t>(why);
  const std::uint64_t count = ++turned_away_[index];
  if (count % kLogEvery != 1) return;
  spdlog::warn("audit: connections closed, {}: {} since the start", kTurnedAwayNames[index], count);
}

Acceptor::Acceptor(Endpoint endpoint, HandOn hand_on, const Limits& limits)
    : endpoint_(std::move(endpoint)),
      hand_on_(std::move(hand_on)),
      limits_{std::min<std::size_t>(limits.connections, sysconf(_SC_OPEN_MAX) / kDescriptors),
              limits.rate, limits.burst},
      listening_(ListenAt(&endpoint_)),
      credit_(limits.burst) {}

Acceptor::~Acceptor() {
  Stop();
}

void Acceptor::Start() {
  thread_ = std::jthread([this](const std::stop_token& stop) { Run(stop); });
}

Acceptor::Counts Acceptor::counts() const {
  Counts counts{.accepted = accepted_, .open = open_};
  for (std::size_t i = 0; i < turned_away_.size(); ++i) counts.turned_away[i] = turned_away_[i];
  return counts;
}

void Acceptor::Describe(const std::string& peer, Client client) {
  const std::scoped_lock lock(mutex_);
  Client& known = clients_[WithoutBrackets(peer)];
  client.rate = std::max(client.rate, known.rate);
  known = std::move(client);
}

void Acceptor::Stop() {
  thread_.request_stop();
  if (thread_.joinable()) thread_.join();
  for (const int fd : std::exchange(listening_, {})) close(fd);
  for (const Connection& one : std::exchange(connections_, {})) close(one.fd);
}

}  // namespace palpate
