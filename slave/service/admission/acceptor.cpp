#include "slave/service/admission/acceptor.h"

#include <algorithm>
#include <cerrno>
#include <compare>
#include <cstring>
#include <map>
#include <memory>
#include <utility>

#include <fcntl.h>
#include <linux/tcp.h>
#include <netinet/in.h>
#include <poll.h>
#include <spdlog/spdlog.h>
#include <sys/ioctl.h>
#include <sys/resource.h>
#include <sys/socket.h>
#include <unistd.h>

#include "shared/link/tcp_line.h"
#include "shared/link/thread_priority.h"
#include "shared/state/clock.h"
#include "slave/service/admission/connection_budget.h"

namespace palpate {
namespace {

constexpr std::chrono::milliseconds kLookSoon(1);  // while somebody is new; at most so often
constexpr double kNew = 0.2;                       // [s]
// [bytes] that wait at most for gRPC, of who is new and of others: 500 commands a second for 5 s of
// round trip.
constexpr int kFewBytes = 8 * 1024, kManyBytes = 512 * 1024;
constexpr std::chrono::milliseconds kLook(5);    // between two looks at what everybody sent
constexpr std::chrono::milliseconds kAlone(50);  // nobody is there; the end must be heard, too
constexpr int kAtOnce = 64;                      // accepted before others are looked at
constexpr double kDwell = 3e-3;                  // [s] before the door, whatever the greeting
constexpr double kSeldom = 50e-3;  // [s] between two looks at who greeted and may not come in yet
// [s] between two that are handed on, whoever they are: gRPC greets them in the threads that read
// the operator's commands, which a crowd at once keeps for longer than a hand may wait.
constexpr double kBetween = 4e-3;
constexpr double kFewAtFirst = 1;           // come in together after somebody sent too much
constexpr double kTrustAgain = 1;           // [s] between two looks whether who is in may stay
constexpr std::size_t kTurnsToTell = 1000;  // once as many more were turned away, the log says so

// Of a peer: IPv4, or the first half of IPv6, which one machine may have all of.
struct Address {
  std::array<std::uint8_t, 16> bytes{};
  auto operator<=>(const Address&) const = default;
};

Address AddressOf(const sockaddr_storage& peer) {
  Address address;
  if (peer.ss_family == AF_INET) {
    const auto& v4 = reinterpret_cast<const sockaddr_in&>(peer);
    std::memcpy(&address.bytes[12], &v4.sin_addr, sizeof v4.sin_addr);
  } else if (peer.ss_family == AF_INET6) {
    const auto& v6 = reinterpret_cast<const sockaddr_in6&>(peer);
    std::memcpy(address.bytes.data(), &v6.sin6_addr, sizeof v6.sin6_addr / 2);
  }
  return address;
}

// What the system counted of a connection.
struct Traffic {
  bool open = false;
  std::uint64_t received = 0, answered = 0;  // [bytes]
};

Traffic TrafficOf(int fd) {
  tcp_info info{};
  socklen_t size = sizeof info;
  if (getsockopt(fd, IPPROTO_TCP, TCP_INFO, &info, &size) != 0) return {};
  constexpr int kEstablished = 1;  // TCP_ESTABLISHED, of a header that does not go with this one
  return {info.tcpi_state == kEstablished, info.tcpi_bytes_received, info.tcpi_bytes_acked};
}

// That came and nobody has read [bytes].
int UnreadOf(int fd) {
  int unread = 0;
  return ioctl(fd, FIONREAD, &unread) == 0 ? unread : 0;
}

// With all that is still to be read of it, if the system can do that.
void Disconnect(int fd) {
  sockaddr nowhere{};
  nowhere.sa_family = AF_UNSPEC;
  if (connect(fd, &nowhere, sizeof nowhere) != 0) shutdown(fd, SHUT_RDWR);
}

std::size_t Affordable(const Acceptor::Limits& limits) {
  constexpr std::size_t kOthers = 128;  // files, cameras, the listener's own
  rlimit descriptors{};
  if (getrlimit(RLIMIT_NOFILE, &descriptors) != 0) return limits.connections;
  const std::size_t spoken_for = limits.waiting + kOthers;
  const auto all = static_cast<std::size_t>(descriptors.rlim_cur);
  return std::min(limits.connections, all > spoken_for ? (all - spoken_for) / 2 : 1);
}

}  // namespace

Greets CheckGreeting(Greeting greeting, std::string_view bytes) {
  using namespace std::string_view_literals;
  constexpr auto kPreface = "PRI * HTTP/2.0\r\n\r\nSM\r\n\r\n"sv;
  if (greeting == Greeting::kHttp2) {
    const std::size_t seen = std::min(bytes.size(), kPreface.size());
    if (bytes.substr(0, seen) != kPreface.substr(0, seen)) return Greets::kNo;
    return seen == kPreface.size() ? Greets::kYes : Greets::kNotYet;
  }
  // A record of a handshake, TLS 1.x, that begins with a client's hello.
  constexpr std::size_t kMajor = 1, kHello = 5;
  const auto differs = [&](std::size_t at, char wanted) {
    return bytes.size() > at && bytes[at] != wanted;
  };
  if (differs(0, '\x16') || differs(kMajor, '\x03') || differs(kHello, '\x01')) return Greets::kNo;
  return bytes.size() > kHello ? Greets::kYes : Greets::kNotYet;
}

std::string_view ToString(TurnedAway why) {
  constexpr std::array<std::string_view, kTurnedAwayCount> kNames{
      "said_nothing", "said_other", "too_many", "too_much", "untrusted"};
  return kNames[static_cast<std::size_t>(why)];
}

// Who is there: the acceptor's thread's own.
class Acceptor::Room {
 public:
  explicit Room(Acceptor& door)
      : door_(door), limits_(door.limits_), most_(Affordable(door.limits_)) {}
  ~Room();

  void Run(const std::stop_token& stop);

 private:
  struct Waiting {
    int fd;
    std::string peer;
    Address from;
    Time since;
    Time looked{};         // at what came
    bool silent = false;   // not a byte yet when looked at: the system says when there is one
    bool greeted = false;  // as our clients do
  };
  struct Guest {
    int fd;  // a second name of the one that was handed on: it cannot come to mean another
    std::string peer;
    Address from;
    ConnectionBudget budget;
    Time since, looked = since;
    bool is_new = true;
    std::function<bool()> trusted = {};  // empty: for ever
    bool is_paced = false;
    std::uint64_t sent = 0;  // and acknowledged when the pace was last decided [bytes]
  };
  struct Visits {
    double credit;
    Time closed_until{}, full_until{};
    std::size_t open = 0;
  };

  [[nodiscard]] std::chrono::milliseconds Pause() const {
    if (guests_.empty() && waiting_.empty()) return kAlone;
    return Clock::now() - newest_at_ < Seconds(kNew) ? kLookSoon : kLook;
  }
  void WaitForSomebody();
  void AcceptAll(int listener);
  void Greet();
  // False: it still waits.
  bool Decide(Waiting* one);
  bool ReadPreface(Waiting* one);
  // Whether there is anything to find out: a crowd that waits is not asked again for each newcomer.
  [[nodiscard]] bool IsToBeLookedAt(const Waiting& one, Time now);
  // Whether the next one may be of this address, if there is a place.
  [[nodiscard]] bool IsItsTurn(const Address& from, Time now);
  bool HandOnIfAllowed(const Waiting& one);
  bool MakePlace(const Address& from);
  void CheckConnections(double dt);
  void Learn();
  void CutUntrusted();
  void Pace(double dt);
  Visits& VisitsOf(const Address& from) {
    return visits_.try_emplace(from, Visits{limits_.burst}).first->second;
  }
  void CloseTo(const Address& from);
  void Cut(const Guest& guest, TurnedAway why);
  // False: it is gone.
  bool Bear(Guest* guest, Time now);
  bool TurnAway(int fd, TurnedAway why);

  Acceptor& door_;
  const Limits& limits_;
  const std::size_t most_;
  std::vector<Waiting> waiting_;  // eldest first
  std::vector<Guest> guests_;
  std::map<Address, Visits> visits_;
  std::vector<pollfd> polled_;
  Time trust_again_{}, newest_at_{}, paced_at_ = Clock::now();
};

Acceptor::Room::~Room() {
  for (const Waiting& one : waiting_) close(one.fd);
  for (const Guest& guest : guests_) close(guest.fd);
}

void Acceptor::Room::Run(const std::stop_token& stop) {
  MakeThreadRealtime(kDoorPriority);
  for (Time looked = Clock::now(); !stop.stop_requested();) {
    WaitForSomebody();
    // Where a crowd comes, each round is for many of it.
    std::this_thread::sleep_until(door_.looked_.load() + kLookSoon);
    for (const ListeningSocket& socket : door_.sockets_) AcceptAll(socket.fd());
    Greet();
    const Time now = Clock::now();
    door_.looked_ = now;
    door_.waiting_ = waiting_.size();
    if (now - looked < Pause()) continue;
    CheckConnections(SecondsBetween(looked, now));
    looked = now;
    if (const double dt = SecondsBetween(paced_at_, now); dt >= BulkPace::kPeriod) {
      Pace(dt);
      paced_at_ = now;
    }
    if (now < trust_again_) continue;
    CutUntrusted();
    trust_again_ = now + Seconds(kTrustAgain);
  }
}

void Acceptor::Room::WaitForSomebody() {
  polled_.clear();
  for (const ListeningSocket& socket : door_.sockets_) polled_.push_back({socket.fd(), POLLIN, 0});
  for (const Waiting& one : waiting_) {
    if (one.silent) polled_.push_back({one.fd, POLLIN, 0});
  }
  if (poll(polled_.data(), polled_.size(), static_cast<int>(Pause().count())) <= 0) return;
  auto polled = polled_.begin() + static_cast<std::ptrdiff_t>(door_.sockets_.size());
  for (Waiting& one : waiting_) {
    if (one.silent) one.silent = (polled++)->revents == 0;
  }
}

void Acceptor::Room::AcceptAll(int listener) {
  for (int i = 0; i < kAtOnce; ++i) {
    sockaddr_storage peer{};
    socklen_t size = sizeof peer;
    const int fd =
        accept4(listener, reinterpret_cast<sockaddr*>(&peer), &size, SOCK_CLOEXEC | SOCK_NONBLOCK);
    if (fd < 0) {
      if (errno == EMFILE || errno == ENFILE) std::this_thread::sleep_for(kLook);
      return;  // nobody, or nothing is left to give: not at once again
    }
    if (waiting_.size() >= limits_.waiting) {
      TurnAway(waiting_.front().fd, TurnedAway::kSaidNothing);
      waiting_.erase(waiting_.begin());
    }
    waiting_.push_back({fd, NameOf(peer), AddressOf(peer), Clock::now()});
  }
}

void Acceptor::Room::Greet() {
  std::erase_if(waiting_, [this](Waiting& one) { return Decide(&one); });
}

bool Acceptor::Room::Decide(Waiting* one) {
  const Time now = Clock::now();
  if (IsToBeLookedAt(*one, now)) {
    one->looked = now;
    if (ReadPreface(one)) return true;
  }
  if (now - one->since < limits_.greeting) return false;
  return TurnAway(one->fd, one->greeted ? TurnedAway::kTooMany : TurnedAway::kSaidNothing);
}

bool Acceptor::Room::IsToBeLookedAt(const Waiting& one, Time now) {
  if (one.silent) return false;
  const bool is_soon = !one.greeted || IsItsTurn(one.from, now);
  return now - one.looked >= Seconds(is_soon ? kDwell : kSeldom);
}

bool Acceptor::Room::ReadPreface(Waiting* one) {
  std::array<char, 24> bytes{};
  const ssize_t came = recv(one->fd, bytes.data(), bytes.size(), MSG_PEEK | MSG_DONTWAIT);
  one->silent = came < 0 && errno == EAGAIN;
  if (one->silent) return false;
  if (came <= 0) return TurnAway(one->fd, TurnedAway::kSaidNothing);  // it left
  const Greets greets =
      CheckGreeting(door_.greeting_, {bytes.data(), static_cast<std::size_t>(came)});
  if (greets == Greets::kNo) return TurnAway(one->fd, TurnedAway::kSaidOther);
  one->greeted = greets == Greets::kYes;
  if (!one->greeted) return false;
  // Of a crowd that greeted and left, nobody is to take the place of who still waits.
  if (!TrafficOf(one->fd).open) return TurnAway(one->fd, TurnedAway::kSaidNothing);
  const Time now = one->looked;
  // A flood shows before any of it reaches gRPC; who floods on does not keep the door closed.
  if (UnreadOf(one->fd) > limits_.share * ConnectionBudget::kStart) {
    if (now >= VisitsOf(one->from).closed_until) CloseTo(one->from);
    return TurnAway(one->fd, TurnedAway::kTooMuch);
  }
  return now - one->since > Seconds(kDwell) && HandOnIfAllowed(*one);
}

bool Acceptor::Room::IsItsTurn(const Address& from, Time now) {
  const Visits& visits = VisitsOf(from);
  return visits.credit >= 1 && now >= visits.closed_until && now >= visits.full_until &&
         now - newest_at_ >= Seconds(kBetween);
}

bool Acceptor::Room::HandOnIfAllowed(const Waiting& one) {
  const Time now = one.looked;
  if (!IsItsTurn(one.from, now)) return false;  // in a while, perhaps
  Visits& visits = visits_.at(one.from);
  if (!MakePlace(one.from)) {
    visits.full_until = now + Seconds(kSeldom);
    return false;
  }
  const int second_name = fcntl(one.fd, F_DUPFD_CLOEXEC, 0);
  if (second_name < 0) return TurnAway(one.fd, TurnedAway::kTooMany);
  const int on = 1;
  setsockopt(one.fd, IPPROTO_TCP, TCP_NODELAY, &on, sizeof on);
  PrepareLine(one.fd);
  --visits.credit;
  ++visits.open;
  newest_at_ = now;
  guests_.push_back({second_name, one.peer, one.from, ConnectionBudget(limits_.share), newest_at_});
  setsockopt(one.fd, SOL_SOCKET, SO_RCVBUF, &kFewBytes, sizeof kFewBytes);
  ++door_.accepted_;
  door_.open_ = guests_.size();
  door_.hand_on_(one.fd);
  return true;
}

// Where all places are taken, of the address or at all, one that is idle gives way.
bool Acceptor::Room::MakePlace(const Address& from) {
  const bool own = visits_.at(from).open >= limits_.per_address;
  if (!own && guests_.size() < most_) return true;
  auto idlest = guests_.end();
  for (auto guest = guests_.begin(); guest != guests_.end(); ++guest) {
    if ((own && guest->from != from) || guest->budget.silent() < limits_.idle) continue;
    if (idlest == guests_.end() || guest->budget.silent() > idlest->budget.silent()) idlest = guest;
  }
  if (idlest == guests_.end()) return false;
  Cut(*idlest, TurnedAway::kTooMany);
  guests_.erase(idlest);
  return true;
}

void Acceptor::Room::CheckConnections(double dt) {
  const Time now = Clock::now();
  std::erase_if(guests_, [&](Guest& guest) { return !Bear(&guest, now); });
  door_.open_ = guests_.size();
  for (auto& [address, visits] : visits_) {
    visits.credit = std::min(limits_.burst, visits.credit + limits_.rate * dt);
  }
  std::erase_if(visits_, [&](const auto& entry) {
    const Visits& visits = entry.second;
    return visits.open == 0 && visits.credit >= limits_.burst && now >= visits.closed_until;
  });
}

bool Acceptor::Room::Bear(Guest* guest, Time now) {
  // Only who is new may be a flood that gRPC has begun to read.
  if (!guest->is_new && now - guest->looked < kLook) return true;
  const Traffic traffic = TrafficOf(guest->fd);
  const double dt = SecondsBetween(std::exchange(guest->looked, now), now);
  const bool bears = guest->budget.Update(traffic.received, traffic.answered, dt);
  if (guest->is_new && now - guest->since > Seconds(kNew)) {
    guest->is_new = false;
    setsockopt(guest->fd, SOL_SOCKET, SO_RCVBUF, &kManyBytes, sizeof kManyBytes);
  }
  if (traffic.open && bears) return true;
  if (traffic.open) {
    CloseTo(guest->from);
    Cut(*guest, TurnedAway::kTooMuch);
  } else {
    close(guest->fd);
    --VisitsOf(guest->from).open;
  }
  return false;
}

void Acceptor::Room::CloseTo(const Address& from) {
  Visits& visits = VisitsOf(from);
  visits.closed_until = Clock::now() + Seconds(limits_.closed);
  visits.credit = std::min(visits.credit, kFewAtFirst);
}

void Acceptor::Room::Cut(const Guest& guest, TurnedAway why) {
  Disconnect(guest.fd);
  TurnAway(guest.fd, why);
  --visits_.at(guest.from).open;
}

// With the door's mutex held.
void Acceptor::Room::Learn() {
  for (const std::string& peer : std::exchange(door_.paced_, {})) {
    const auto guest = std::ranges::find(guests_, peer, &Guest::peer);
    if (guest != guests_.end()) guest->is_paced = true;
  }
  for (auto& [peer, trusted] : door_.trusted_) {
    const auto guest = std::ranges::find(guests_, peer, &Guest::peer);
    if (guest != guests_.end()) guest->trusted = std::move(trusted);
  }
  door_.trusted_.clear();
}

void Acceptor::Room::CutUntrusted() {
  {
    const std::scoped_lock lock(door_.mutex_);
    Learn();
  }
  std::erase_if(guests_, [this](const Guest& guest) {
    if (!guest.trusted || guest.trusted()) return false;
    spdlog::warn("audit: {} was disconnected: its certificate is no longer valid", guest.peer);
    Cut(guest, TurnedAway::kUntrusted);
    return true;
  });
}

// Who is paced shares what there is with those who also sent since the last time. The operator's
// own connection is not: its states would wait with the rest.
void Acceptor::Room::Pace(double dt) {
  double sent = 0, rate = 0;
  std::uint64_t busy = 0;
  std::string operator_peer;
  {
    const std::scoped_lock lock(door_.mutex_);
    Learn();
    operator_peer = WithoutBrackets(door_.operator_);
    for (Guest& guest : guests_) {
      const std::uint64_t before = std::exchange(guest.sent, guest.budget.answered());
      if (!guest.is_paced || guest.peer == operator_peer || guest.sent == before) continue;
      sent += static_cast<double>(guest.sent - before);
      ++busy;
    }
    rate = door_.pace_.Update(sent, dt);
  }
  const double share = rate / static_cast<double>(std::max<std::uint64_t>(busy, 1));
  for (const Guest& guest : guests_) {
    if (!guest.is_paced) continue;
    const double most = guest.peer == operator_peer ? BulkPace::kUnbound : share;
    constexpr unsigned kUnbound = ~0U;
    const unsigned told = most < kUnbound ? static_cast<unsigned>(most) : kUnbound;
    setsockopt(guest.fd, SOL_SOCKET, SO_MAX_PACING_RATE, &told, sizeof told);
  }
}

bool Acceptor::Room::TurnAway(int fd, TurnedAway why) {
  close(fd);
  const std::uint64_t count = ++door_.turned_away_[static_cast<std::size_t>(why)];
  if (count % kTurnsToTell == 1) {
    spdlog::warn("audit: connections rejected, {}: {} since the start", ToString(why), count);
  }
  return true;
}

Acceptor::Acceptor(Endpoint endpoint, Greeting greeting, HandOn hand_on, const Limits& limits)
    : endpoint_(std::move(endpoint)),
      greeting_(greeting),
      hand_on_(std::move(hand_on)),
      limits_(limits),
      sockets_(ListenAt(&endpoint_)) {}

Acceptor::~Acceptor() {
  Stop();
}

void Acceptor::Start() {
  thread_ = std::jthread([this](const std::stop_token& stop) { Room(*this).Run(stop); });
}

AcceptorCounts Acceptor::counts() const {
  AcceptorCounts counts;
  counts.accepted = accepted_;
  counts.open = open_;
  counts.waiting = waiting_;
  counts.unseen = SecondsBetween(looked_, Clock::now());
  for (std::size_t i = 0; i < kTurnedAwayCount; ++i) counts.turned_away[i] = turned_away_[i];
  return counts;
}

void Acceptor::KeepWhile(const std::string& peer, std::function<bool()> trusted) {
  const std::scoped_lock lock(mutex_);
  trusted_[WithoutBrackets(peer)] = std::move(trusted);
}

void Acceptor::Pace(const std::string& peer) {
  const std::scoped_lock lock(mutex_);
  paced_.push_back(WithoutBrackets(peer));
}

void Acceptor::HearRoundTrip(const std::string& peer, double round_trip) {
  const std::scoped_lock lock(mutex_);
  if (operator_ != peer) {
    operator_ = peer;
    pace_ = {};
  }
  pace_.Hear(round_trip);
}

void Acceptor::Stop() {
  thread_.request_stop();
  if (thread_.joinable()) thread_.join();
  sockets_.clear();
}

}  // namespace palpate
