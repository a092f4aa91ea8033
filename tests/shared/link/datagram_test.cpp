// Datagrams between two ends: packets of third parties, replays, damaged ones and those of other
// sessions have no effect.
#include <chrono>
#include <functional>
#include <memory>
#include <mutex>
#include <string>
#include <thread>
#include <vector>

#include <arpa/inet.h>
#include <gmock/gmock.h>
#include <gtest/gtest.h>
#include <netinet/in.h>
#include <poll.h>
#include <sys/socket.h>
#include <unistd.h>

#include "shared/link/datagram_line.h"
#include "shared/link/datagram_seal.h"
#include "shared/link/tcp_line.h"
#include "tests/shared/link/datagram_sequence.h"

namespace palpate {
namespace {

using Bytes = std::vector<std::uint8_t>;

Bytes ToBytes(std::string_view text) {
  return {text.begin(), text.end()};
}

Bytes Copy(std::span<const std::uint8_t> bytes) {
  return {bytes.begin(), bytes.end()};
}

class SealTest : public testing::Test {
 protected:
  Bytes Sealed(std::string_view text) { return Copy(sealer_.Seal(ToBytes(text))); }
  bool Opens(const Bytes& sealed) { return !opener_.Open(sealed).empty(); }

  const DatagramKey key_ = NewDatagramKey();
  DatagramSealer sealer_{key_};
  DatagramOpener opener_{key_};
};

// Reference: RFC 8439, section 2.8.2, computed for this key, counter and text by
// an implementation that is not OpenSSL's: thirty lines of Python after the RFC's pseudo-code.
TEST(SealFormat, IsThatOfTheContract) {
  DatagramKey key{};
  for (std::size_t i = 0; i < key.size(); ++i) key[i] = static_cast<std::uint8_t>(i);
  const Bytes sealed = Copy(DatagramSealer(key).Seal(ToBytes("soft")));
  const Bytes expected{0x00, 0x00, 0x00, 0x00, 0x00, 0x00, 0x00, 0x01, 0x1a, 0x33,
                       0x1a, 0xad, 0x9a, 0x40, 0x8d, 0xa1, 0x9b, 0x32, 0xcf, 0x4b,
                       0x71, 0x08, 0xe9, 0xed, 0xcd, 0xd5, 0x3f, 0xd7};
  EXPECT_EQ(sealed, expected);
}

TEST_F(SealTest, SealedDataAreOpenedAndUnreadableOnTheWay) {
  for (const std::string& text : {std::string("x"), std::string(kMaxDatagram - kSealSize, 'y')}) {
    const Bytes sealed = Sealed(text);
    EXPECT_EQ(sealed.size(), text.size() + kSealSize);
    EXPECT_EQ(Copy(opener_.Open(sealed)), ToBytes(text));
  }
  const Bytes once = Sealed("the same"), again = Sealed("the same");
  EXPECT_FALSE(std::equal(once.begin() + 8, once.end(), again.begin() + 8));
}

// A datagram with any changed bit is refused, including the counter's bits; a forged datagram does
// not block later genuine ones.
TEST_F(SealTest, NoBitMayDiffer) {
  const Bytes sealed = Sealed("force");
  for (std::size_t bit = 0; bit < 8 * sealed.size(); ++bit) {
    Bytes damaged = sealed;
    damaged[bit / 8] = static_cast<std::uint8_t>(damaged[bit / 8] ^ (1U << bit % 8));
    EXPECT_FALSE(Opens(damaged)) << "bit " << bit;
  }
  for (std::size_t size = 0; size < sealed.size(); ++size) {
    EXPECT_FALSE(Opens({sealed.begin(), sealed.begin() + static_cast<std::ptrdiff_t>(size)}))
        << size;
  }
  Bytes longer = sealed;
  longer.push_back(0);
  EXPECT_FALSE(Opens(longer));
  EXPECT_TRUE(Opens(sealed));
}

TEST_F(SealTest, AnotherSessionsKeyOpensNothing) {
  EXPECT_FALSE(Opens(Copy(DatagramSealer(NewDatagramKey()).Seal(ToBytes("old")))));
}

sockaddr_storage Loopback(int family) {
  sockaddr_storage address{};
  address.ss_family = static_cast<sa_family_t>(family);
  if (family == AF_INET6) {
    reinterpret_cast<sockaddr_in6&>(address).sin6_addr = in6addr_loopback;
  } else {
    reinterpret_cast<sockaddr_in&>(address).sin_addr.s_addr = htonl(INADDR_LOOPBACK);
  }
  return address;
}

// The received datagrams, as the line's thread passes them on.
class Heard {
 public:
  DatagramLine::OnMessage take() {
    return [this](std::string_view plain) {
      const std::scoped_lock lock(mutex_);
      texts_.emplace_back(plain);
      return DatagramLine::LinkFeedback{};
    };
  }
  [[nodiscard]] std::vector<std::string> texts() const {
    const std::scoped_lock lock(mutex_);
    return texts_;
  }

 private:
  mutable std::mutex mutex_;  // guards the next one
  std::vector<std::string> texts_;
};

// Sends `text` again and again, since none need arrive, until `condition` holds.
bool SendUntil(DatagramLine* line, const std::string& text,
               const std::function<bool()>& condition) {
  const auto end = std::chrono::steady_clock::now() + std::chrono::seconds(20);
  while (!condition()) {
    if (std::chrono::steady_clock::now() > end) return false;
    line->Send(text);
    std::this_thread::sleep_for(std::chrono::milliseconds(2));
  }
  return true;
}

// A sender without a key, at another address.
class Stranger {
 public:
  explicit Stranger(const sockaddr_storage& at) : fd_(socket(AF_INET, SOCK_DGRAM, 0)), at_(at) {
    const sockaddr_storage own = Loopback(AF_INET);
    if (bind(fd_, reinterpret_cast<const sockaddr*>(&own), sizeof(sockaddr_in)) != 0) std::abort();
  }
  ~Stranger() { close(fd_); }
  Stranger(const Stranger&) = delete;
  Stranger& operator=(const Stranger&) = delete;

  void Send(const Bytes& bytes) const {
    sendto(fd_, bytes.data(), bytes.size(), 0, reinterpret_cast<const sockaddr*>(&at_),
           sizeof(sockaddr_in));
  }
  [[nodiscard]] bool IsAnswered() const {
    pollfd one{fd_, POLLIN, 0};
    return poll(&one, 1, 100) == 1;
  }
  // The datagrams that wait in the socket.
  [[nodiscard]] Bytes Receive() const {
    Bytes bytes(2 * kMaxDatagram);
    const ssize_t came = recv(fd_, bytes.data(), bytes.size(), MSG_DONTWAIT);
    bytes.resize(came < 0 ? 0 : static_cast<std::size_t>(came));
    return bytes;
  }

 private:
  int fd_;
  sockaddr_storage at_;
};

// A sender with keys, and its address.
class LineTest : public testing::Test {
 protected:
  std::unique_ptr<DatagramLine> Call() {
    return std::make_unique<DatagramLine>(DatagramLine::Role::kCalls, At(),
                                          DatagramLine::Keys{keys_.receive, keys_.send},
                                          caller_heard_.take());
  }
  sockaddr_storage At() const {
    sockaddr_storage at = Loopback(AF_INET);
    reinterpret_cast<sockaddr_in&>(at).sin_port = htons(answerer_.port());
    return at;
  }

  const DatagramLine::Keys keys_{NewDatagramKey(), NewDatagramKey()};
  Heard heard_, caller_heard_;
  DatagramLine answerer_{DatagramLine::Role::kAnswers, Loopback(AF_INET), keys_, heard_.take()};
};

TEST_F(LineTest, DatagramsOfStrangersAreIgnoredWithoutHarm) {
  const Stranger stranger(At());
  for (std::size_t size = 0; size < 2 * kMaxDatagram; ++size) stranger.Send(Bytes(size));
  answerer_.Send("state");
  EXPECT_FALSE(stranger.IsAnswered());
  EXPECT_TRUE(heard_.texts().empty());
  const auto caller = Call();
  EXPECT_TRUE(SendUntil(caller.get(), "command", [&] { return !heard_.texts().empty(); }));
}

// A third party repeats observed datagrams from its own address.
TEST_F(LineTest, AReplayIsNotHeardAndTurnsNoAnswersAside) {
  DatagramSealer caller(keys_.receive);
  const Stranger honest(At()), replaying(At());
  const Bytes sealed = Copy(caller.Seal(ToBytes("command")));
  honest.Send(sealed);
  ASSERT_TRUE(SendUntil(&answerer_, "state", [&] { return honest.IsAnswered(); }));
  replaying.Send(sealed);
  answerer_.Send("another state");
  EXPECT_FALSE(replaying.IsAnswered());
  EXPECT_EQ(heard_.texts(), std::vector<std::string>{"command"});
}

// Each direction has its own key.
TEST_F(LineTest, AnAnswerSentBackIsNotHeard) {
  DatagramSealer caller(keys_.receive);
  const Stranger honest(At());
  honest.Send(Copy(caller.Seal(ToBytes("command"))));
  ASSERT_TRUE(SendUntil(&answerer_, "state", [&] { return honest.IsAnswered(); }));
  for (Bytes state = honest.Receive(); !state.empty(); state = honest.Receive()) honest.Send(state);
  honest.Send(Copy(caller.Seal(ToBytes("the next"))));
  ASSERT_TRUE(SendUntil(&answerer_, "state", [&] { return heard_.texts().size() > 1; }));
  EXPECT_EQ(heard_.texts(), (std::vector<std::string>{"command", "the next"}));
}

TEST(DatagramLineTest, WorksOverIpv6) {
  Heard heard;
  const DatagramLine::Keys keys{NewDatagramKey(), NewDatagramKey()};
  std::unique_ptr<DatagramLine> answerer;
  try {
    answerer = std::make_unique<DatagramLine>(DatagramLine::Role::kAnswers, Loopback(AF_INET6),
                                              keys, heard.take());
  } catch (const std::system_error& error) {
    GTEST_SKIP() << "no IPv6 here: " << error.what();
  }
  sockaddr_storage at = Loopback(AF_INET6);
  reinterpret_cast<sockaddr_in6&>(at).sin6_port = htons(answerer->port());
  DatagramLine caller(DatagramLine::Role::kCalls, at, {keys.receive, keys.send}, heard.take());
  EXPECT_TRUE(SendUntil(&caller, "command", [&] { return !heard.texts().empty(); }));
}

TEST(EndsOfALine, AreFoundByThePeersName) {
  // A socket for IPv4 and IPv6, like gRPC's, writes IPv4 addresses in a mapped form.
  const int listener = socket(AF_INET, SOCK_STREAM, 0), client = socket(AF_INET6, SOCK_STREAM, 0);
  sockaddr_storage at = Loopback(AF_INET);
  socklen_t size = sizeof(sockaddr_in);
  ASSERT_EQ(bind(listener, reinterpret_cast<sockaddr*>(&at), size), 0);
  ASSERT_EQ(listen(listener, 1), 0);
  ASSERT_EQ(getsockname(listener, reinterpret_cast<sockaddr*>(&at), &size), 0);
  sockaddr_in6 mapped{};
  mapped.sin6_family = AF_INET6;
  mapped.sin6_port = reinterpret_cast<sockaddr_in&>(at).sin_port;
  ASSERT_EQ(inet_pton(AF_INET6, "::ffff:127.0.0.1", &mapped.sin6_addr), 1);
  if (connect(client, reinterpret_cast<sockaddr*>(&mapped), sizeof mapped) != 0) {
    GTEST_SKIP() << "no IPv6 here";
  }
  const auto ends = EndsOf(NameOf(at));
  close(client);
  close(listener);
  ASSERT_TRUE(ends.has_value());
  EXPECT_EQ(NameOf(ends->far), NameOf(at));
  EXPECT_NE(NameOf(ends->own), NameOf(at));
  EXPECT_FALSE(EndsOf("ipv4:192.0.2.1:5"));
  EXPECT_EQ(WithoutBrackets("ipv6:%5B::1%5D:7"), "ipv6:::1:7");
}

// `tests/fuzz` searches for further sequences.
TEST(DatagramSequence, OnlyWhatIsNewAndUnharmedOpens) {
  for (unsigned seed = 1; seed <= 300; ++seed) {
    const auto bytes = RandomBytes(seed, 4000);
    EXPECT_NO_THROW(RunDatagrams(Choices(bytes))) << "seed " << seed;
  }
}

}  // namespace
}  // namespace palpate
