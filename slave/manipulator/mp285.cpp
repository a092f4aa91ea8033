#include "slave/manipulator/mp285.h"

#include <algorithm>
#include <cerrno>
#include <cstdlib>
#include <cstring>
#include <stdexcept>

#include <fcntl.h>
#include <fmt/format.h>
#include <poll.h>
#include <termios.h>
#include <unistd.h>

namespace palpate {
namespace {

using SteadyClock = std::chrono::steady_clock;

constexpr char kEnd = '\r', kInterrupt = '\x03';
constexpr int kAway = 4;  // patiences without a whole answer: it may have been switched off
constexpr std::size_t kPlaceBytes = 12;  // x, y, z, four bytes each, the lowest first

const char* ErrorInWords(char code) {
  switch (code) {
    case '0':
      return "a character arrived before the previous one was read (error 0)";
    case '1':
      return "a character without a stop bit (error 1)";
    case '2':
      return "input without an end character (error 2)";
    case '4':
      return "unknown command (error 4)";
    case '8':
      return "a move was interrupted (error 8)";
    default:
      return "a malformed answer";
  }
}

std::string ToBytes(const Steps& steps) {
  std::string bytes;
  for (const std::int32_t axis : steps) {
    for (int k = 0; k < 4; ++k)
      bytes += static_cast<char>(static_cast<std::uint32_t>(axis) >> 8 * k);
  }
  return bytes;
}

Steps FromBytes(std::string_view bytes) {
  Steps steps{};
  for (std::size_t i = 0; i < kPlaceBytes; ++i) {
    const auto byte = static_cast<unsigned char>(bytes[i]);
    const auto so_far = static_cast<std::uint32_t>(steps[i / 4]);
    steps[i / 4] = static_cast<std::int32_t>(so_far | std::uint32_t{byte} << 8 * (i % 4));
  }
  return steps;
}

// Counted from an origin that is set anywhere on the travel. `known`: where it stood, if anywhere,
// from which nothing is farther than the travel.
bool IsWithinTravel(const Steps& steps, const std::optional<Steps>& known) {
  const auto is_within = [](std::int64_t s) { return std::abs(s) <= Mp285::kTravel; };
  for (std::size_t i = 0; i < steps.size(); ++i) {
    if (!is_within(steps[i])) return false;
    if (known && !is_within(std::int64_t{steps[i]} - (*known)[i])) return false;
  }
  return true;
}

std::string InWords(const Steps& s) {
  return fmt::format("({:.2f}, {:.2f}, {:.2f}) um", s[0] * 1e6 * Mp285::kStep,
                     s[1] * 1e6 * Mp285::kStep, s[2] * 1e6 * Mp285::kStep);
}

// Whether `steps` lie between two places, axis by axis.
bool IsBetween(const Steps& steps, const Steps& a, const Steps& b) {
  for (std::size_t i = 0; i < steps.size(); ++i) {
    if (steps[i] < std::min(a[i], b[i]) || steps[i] > std::max(a[i], b[i])) return false;
  }
  return true;
}

}  // namespace

Mp285::Mp285(const std::string& port, Patience patience) : port_(port), patience_(patience) {
  if (Open()) return;
  throw std::runtime_error("manipulator.port = " + port +
                           ": cannot open the serial port: " + std::strerror(errno));
}

Mp285::~Mp285() {
  Close();
}

bool Mp285::Open() {
  line_ = open(port_.c_str(), O_RDWR | O_NOCTTY | O_CLOEXEC | O_NONBLOCK);
  termios settings{};
  if (line_ < 0) return false;
  if (tcgetattr(line_, &settings) != 0) {
    const int why = errno;
    Close();
    errno = why;
    return false;
  }
  cfmakeraw(&settings);
  cfsetspeed(&settings, B9600);
  settings.c_cflag |= CLOCAL | CREAD;
  tcsetattr(line_, TCSANOW, &settings);
  return true;
}

void Mp285::Close() {
  if (line_ >= 0) close(line_);
  line_ = -1;
}

void Mp285::Lose() {
  Close();
  was_away_ = true;
}

bool Mp285::Know(const Steps& at) {
  at_ = known_ = sent_ = at;
  was_away_ = false;
  return true;
}

bool Mp285::Fail(const std::string& why) {
  fault_ = "the micromanipulator: " + why;
  at_.reset();
  return false;
}

bool Mp285::Send(std::string_view bytes) {
  const auto end = SteadyClock::now() + patience_;
  while (!bytes.empty() && SteadyClock::now() < end) {
    const ssize_t sent = write(line_, bytes.data(), bytes.size());
    if (sent > 0) bytes.remove_prefix(static_cast<std::size_t>(sent));
    if (sent < 0 && errno != EAGAIN && errno != EINTR) {
      Lose();
      break;
    }
    pollfd ready{line_, POLLOUT, 0};
    if (!bytes.empty()) poll(&ready, 1, 1);
  }
  return bytes.empty() || Fail("the serial port accepts no data");
}

std::optional<std::string> Mp285::Read(std::size_t bytes, Patience patience) {
  std::string came;
  const auto end = SteadyClock::now() + patience;
  while (came.size() < bytes) {
    const auto left = std::chrono::duration_cast<Patience>(end - SteadyClock::now());
    pollfd ready{line_, POLLIN, 0};
    if (left.count() < 0 || poll(&ready, 1, static_cast<int>(left.count()) + 1) <= 0) break;
    char buffer[32];
    const ssize_t got = read(line_, buffer, std::min(sizeof buffer, bytes - came.size()));
    if (got == 0 || (got < 0 && errno != EAGAIN && errno != EINTR)) {
      Lose();
      break;
    }
    if (got > 0) came.append(buffer, static_cast<std::size_t>(got));
  }
  return came.size() == bytes ? std::optional(came) : std::nullopt;
}

void Mp285::Empty() {
  tcflush(line_, TCIFLUSH);
  // What is under way still comes: until nothing does any more.
  for (int k = 0; k < 64 && Read(1, patience_); ++k) tcflush(line_, TCIFLUSH);
}

std::optional<Steps> Mp285::QuerySteps() {
  if (!Send(std::string{'c', kEnd})) return std::nullopt;
  const auto answer = Read(kPlaceBytes + 1, patience_);
  if (!answer) {
    Fail("no complete answer to the position query");
  } else if (answer->back() != kEnd || !IsWithinTravel(FromBytes(*answer), known_)) {
    Fail("a malformed answer to the position query");
  } else {
    heard_at_ = SteadyClock::now();
    return FromBytes(*answer);
  }
  return std::nullopt;
}

bool Mp285::Find() {
  at_.reset();
  was_away_ = was_away_ || SteadyClock::now() - heard_at_ > kAway * patience_;
  if (line_ < 0 && !Open())
    return Fail("the serial port is gone: " + std::string(std::strerror(errno)));
  if (!Send(std::string(1, kInterrupt))) return false;
  Empty();
  const auto once = QuerySteps(), again = once ? QuerySteps() : std::nullopt;
  if (!again) return false;
  if (*once != *again)
    return Fail("it reports two different positions, " + InWords(*once) + " and " +
                InWords(*again));
  if (was_away_ && known_ && !IsBetween(*again, *known_, *sent_)) {
    return Fail("its position was " + InWords(*known_) + " and is now " + InWords(*again) +
                ": it was switched off and on, or moved by hand; accepted is a restart of the "
                "slave at home");
  }
  fault_.clear();
  return Know(*again);
}

bool Mp285::MoveTo(const Steps& steps, Patience takes) {
  if (!at_) return false;
  if (!IsWithinTravel(steps, known_))
    return Fail(InWords(steps) + " is beyond its travel of 25 mm");
  sent_ = steps;
  if (!Send(std::string(1, 'm') + ToBytes(steps) + kEnd)) return false;
  const auto done = Read(1, takes + patience_);
  if (!done) return Fail("a move did not finish");
  if (done->front() != kEnd) return Fail(ErrorInWords(done->front()));
  const auto there = QuerySteps();
  if (!there) return false;
  if (*there != steps) {
    const auto again = QuerySteps();
    if (!again) return false;
    if (*again != steps) {
      return Fail("its position is " + InWords(*again) + ", commanded was " + InWords(steps));
    }
  }
  return Know(steps);
}

bool Mp285::Poll() {
  if (!at_) return false;
  const auto once = QuerySteps();
  if (!once) return false;
  if (*once == *at_) return true;
  const auto again = QuerySteps();
  if (!again) return false;
  if (*again != *once) return Fail("it reports two different positions");
  return Know(*again);
}

}  // namespace palpate
