#include "master/device/keyboard/keyboard_source.h"

#include <csignal>
#include <string_view>
#include <utility>

#include <poll.h>
#include <unistd.h>

namespace palpate {
namespace {

struct Move {
  std::string_view bytes;  // after the escape character
  int axis;
  double sign;
};
// Arrows in both modes of a terminal; page up and down.
constexpr std::array<Move, 10> kMoves{{{"[C", 0, 1},
                                       {"[D", 0, -1},
                                       {"[A", 1, 1},
                                       {"[B", 1, -1},
                                       {"OC", 0, 1},
                                       {"OD", 0, -1},
                                       {"OA", 1, 1},
                                       {"OB", 1, -1},
                                       {"[6~", 2, 1},
                                       {"[5~", 2, -1}}};

}  // namespace

void KeyboardState::Take(const char* bytes, std::size_t size, Time now) {
  std::string_view left(bytes, size);
  while (!left.empty()) {
    const char key = left.front();
    left.remove_prefix(1);
    if (key == 'e' || key == 'E') {
      engaged_ = !engaged_;
    } else if (key == 'r' || key == 'R') {
      reset_ = true;
    } else {
      const auto is_move = [&](const Move& move) { return left.starts_with(move.bytes); };
      const auto* move = key == '\x1b' ? std::ranges::find_if(kMoves, is_move) : kMoves.end();
      if (move == kMoves.end()) {
        stop_ = true;
        engaged_ = false;
        return;  // the rest may belong to an unknown key
      }
      TakeMove(move->axis, move->sign, now);
      left.remove_prefix(move->bytes.size());
    }
  }
}

void KeyboardState::TakeMove(int axis, double sign, Time now) {
  sign_[static_cast<std::size_t>(axis)] = sign;
  moved_at_[static_cast<std::size_t>(axis)] = now;
}

RateInput KeyboardState::At(Time now) const {
  RateInput input;
  input.engaged = engaged_;
  input.buttons = engaged_ ? 1 : 0;
  for (int i = 0; i < 3; ++i) {
    const auto axis = static_cast<std::size_t>(i);
    const bool moves =
        moved_at_[axis] != Time{} && SecondsBetween(moved_at_[axis], now) < kKeyMoves;
    input.share[i] = moves ? sign_[axis] : 0;
  }
  return input;
}

bool KeyboardState::TakeStop() {
  return std::exchange(stop_, false);
}

bool KeyboardState::TakeReset() {
  return std::exchange(reset_, false);
}

KeyboardSource::KeyboardSource() {
  if (tcgetattr(STDIN_FILENO, &before_) != 0) {
    throw DeviceUnavailable("keyboard", "the standard input is no terminal");
  }
  termios raw = before_;
  raw.c_lflag &= ~static_cast<tcflag_t>(ICANON | ECHO);  // signals such as Ctrl+C stay
  raw.c_cc[VMIN] = 0;
  raw.c_cc[VTIME] = 0;
  tcsetattr(STDIN_FILENO, TCSANOW, &raw);
}

KeyboardSource::~KeyboardSource() {
  tcsetattr(STDIN_FILENO, TCSANOW, &before_);
}

RateInput KeyboardSource::Poll(Time now) {
  pollfd input{STDIN_FILENO, POLLIN, 0};
  std::array<char, 256> bytes{};
  if (!gone_ && poll(&input, 1, 0) > 0) {
    gone_ = (input.revents & ~POLLIN) != 0;
    const ssize_t size = gone_ ? 0 : read(STDIN_FILENO, bytes.data(), bytes.size());
    if (size > 0) state_.Take(bytes.data(), static_cast<std::size_t>(size), now);
  }
  if (state_.TakeStop()) kill(getpid(), SIGUSR1);
  if (state_.TakeReset()) kill(getpid(), SIGUSR2);
  RateInput now_commanded = state_.At(now);
  if (gone_) {
    now_commanded.fault = DeviceFault::kUnplugged;
    now_commanded.cause = "the terminal is closed";
  }
  return now_commanded;
}

Driver KeyboardDriver() {
  return {"keyboard", "keys of this terminal, without force", "speed in mm/s, 20 by default",
          [] {
            DriverReport report;
            report.searched.emplace_back("a terminal as standard input");
            if (isatty(STDIN_FILENO) != 0) {
              report.found.emplace_back(ttyname(STDIN_FILENO));
              report.usable = true;
            } else {
              report.missing.emplace_back("a terminal: the standard input is a file or pipe");
              report.next = "start palpate-master in a terminal";
            }
            return report;
          },
          [](const std::string& option) -> std::unique_ptr<HapticDevice> {
            const double speed = SpeedOf("keyboard", option);
            return std::make_unique<RateDevice>(std::make_unique<KeyboardSource>(), speed);
          }};
}

}  // namespace palpate
