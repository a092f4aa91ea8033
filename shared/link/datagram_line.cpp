#include "shared/link/datagram_line.h"

#include <array>
#include <cerrno>
#include <mutex>
#include <system_error>
#include <utility>

#include <netinet/in.h>
#include <poll.h>
#include <sys/eventfd.h>
#include <unistd.h>

#include "shared/link/thread_priority.h"

namespace palpate {
namespace {

// At most kMaxInWindow datagrams are processed per window: both ends send 200 to 1000 per second.
constexpr std::chrono::milliseconds kWindow(1);
constexpr int kMaxInWindow = 8;
// Size of the receive buffer [bytes]. It is small: old datagrams are useless, and a flood must not
// leave a long queue before valid ones.
constexpr int kMaxWaiting = 32 * 1024;

socklen_t SizeOf(const sockaddr_storage& address) {
  return address.ss_family == AF_INET6 ? sizeof(sockaddr_in6) : sizeof(sockaddr_in);
}

const sockaddr* Generic(const sockaddr_storage& address) {
  return reinterpret_cast<const sockaddr*>(&address);
}

[[noreturn]] void Fail(const char* what) {
  throw std::system_error(errno, std::generic_category(), what);
}

void Bind(int fd, sockaddr_storage own) {
  if (bind(fd, Generic(own), SizeOf(own)) == 0) return;
  reinterpret_cast<sockaddr_in6&>(own).sin6_port = 0;  // at the same offset as in sockaddr_in
  if (errno != EADDRINUSE || bind(fd, Generic(own), SizeOf(own)) != 0) Fail("datagrams: bind");
}

}  // namespace

DatagramLine::Descriptor::Descriptor(int opened) : fd(opened) {
  if (fd < 0) Fail("datagrams: open");
}

DatagramLine::Descriptor::~Descriptor() {
  close(fd);
}

DatagramLine::DatagramLine(Role role, const sockaddr_storage& at, const Keys& keys,
                           OnMessage on_message)
    : role_(role),
      socket_(socket(at.ss_family, SOCK_DGRAM | SOCK_CLOEXEC | SOCK_NONBLOCK, 0)),
      wake_(eventfd(0, EFD_CLOEXEC | EFD_NONBLOCK)),
      on_message_(std::move(on_message)),
      sealer_(keys.send),
      opener_(keys.receive) {
  setsockopt(socket_.fd, SOL_SOCKET, SO_RCVBUF, &kMaxWaiting, sizeof kMaxWaiting);
  if (role == Role::kAnswers) {
    Bind(socket_.fd, at);
  } else {
    if (connect(socket_.fd, Generic(at), SizeOf(at)) != 0) Fail("datagrams: connect");
    peer_ = at;
  }
  thread_ = std::jthread([this](const std::stop_token& stop) { Run(stop); });
}

DatagramLine::~DatagramLine() {
  thread_.request_stop();
  eventfd_write(wake_.fd, 1);
  thread_.join();
}

void DatagramLine::Send(std::string_view plain) noexcept {
  std::optional<sockaddr_storage> to;
  {
    const std::scoped_lock lock(mutex_);
    const Time now = Clock::now();
    const bool is_there = role_ == Role::kCalls || now - received_at_ < kSilence;
    if (is_there && peer_ && pace_.Allows(now)) to = peer_;
  }
  if (!to) return;
  const auto sealed =
      sealer_.Seal({reinterpret_cast<const std::uint8_t*>(plain.data()), plain.size()});
  if (sealed.empty()) return;
  sendto(socket_.fd, sealed.data(), sealed.size(), MSG_DONTWAIT | MSG_NOSIGNAL, Generic(*to),
         SizeOf(*to));
}

void DatagramLine::StreamMoves() noexcept {
  const std::scoped_lock lock(mutex_);
  pace_.StreamMoves(Clock::now());
}

std::uint16_t DatagramLine::port() const {
  sockaddr_in6 own{};  // the port is at the same offset as in sockaddr_in
  socklen_t size = sizeof own;
  getsockname(socket_.fd, reinterpret_cast<sockaddr*>(&own), &size);
  return ntohs(own.sin6_port);
}

void DatagramLine::Run(const std::stop_token& stop) {
  MakeThreadRealtime(kReadingPriority);
  std::array<pollfd, 2> both{{{socket_.fd, POLLIN, 0}, {wake_.fd, POLLIN, 0}}};
  while (!stop.stop_requested()) {
    poll(both.data(), both.size(), -1);
    Pace();
    ReceiveNext();
  }
}

void DatagramLine::ReceiveNext() {
  // One byte more, to detect datagrams that are too large.
  std::array<std::uint8_t, kMaxDatagram + 1> bytes;
  sockaddr_storage from{};
  socklen_t size = sizeof from;
  const ssize_t size_received = recvfrom(socket_.fd, bytes.data(), bytes.size(), MSG_DONTWAIT,
                                         reinterpret_cast<sockaddr*>(&from), &size);
  if (size_received <= 0) return;
  const auto plain = opener_.Open(std::span(bytes).first(static_cast<std::size_t>(size_received)));
  if (plain.empty()) return;
  newest_ = opener_.newest();
  ++received_;
  {
    const std::scoped_lock lock(mutex_);
    received_at_ = Clock::now();
    if (role_ == Role::kAnswers) peer_ = from;
  }
  const LinkFeedback feedback =
      on_message_({reinterpret_cast<const char*>(plain.data()), plain.size()});
  const std::scoped_lock lock(mutex_);
  pace_.AddFeedback(feedback.seen, feedback.round_trip, Clock::now());
}

void DatagramLine::Pace() {
  const Time now = Clock::now();
  if (now - window_began_ >= kWindow) {
    window_began_ = now;
    processed_ = 0;
  }
  if (++processed_ > kMaxInWindow) {
    std::this_thread::sleep_until(Clock::ToSteady(window_began_ + kWindow));
    window_began_ = Clock::now();
    processed_ = 1;
  }
}

}  // namespace palpate
