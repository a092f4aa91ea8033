// A micromanipulator that exists only behind a pseudo-terminal, and the ways in which its line
// fails.
#pragma once

#include <algorithm>
#include <atomic>
#include <mutex>
#include <random>
#include <stdexcept>
#include <string>
#include <thread>
#include <utility>

#include <fcntl.h>
#include <poll.h>
#include <stdlib.h>
#include <termios.h>
#include <unistd.h>

#include "slave/manipulator/mp285.h"

namespace palpate {

class FakeMp285 {
 public:
  // Of a hundred answers so many fail, each in one of kFailures ways.
  explicit FakeMp285(int failing = 0, unsigned seed = 1)
      : failing_(failing), random_(seed), line_(posix_openpt(O_RDWR | O_NOCTTY)) {
    if (line_ < 0 || grantpt(line_) != 0 || unlockpt(line_) != 0) {
      throw std::runtime_error("no pseudo-terminal");
    }
    port_ = ptsname(line_);
    kept_ = open(port_.c_str(), O_RDWR | O_NOCTTY);  // so that it never hangs up
    termios settings{};
    tcgetattr(kept_, &settings);
    cfmakeraw(&settings);
    tcsetattr(kept_, TCSANOW, &settings);
    thread_ = std::jthread([this](const std::stop_token& stop) { Run(stop); });
  }
  ~FakeMp285() {
    thread_ = {};
    close(kept_);
    close(line_);
  }
  FakeMp285(const FakeMp285&) = delete;
  FakeMp285& operator=(const FakeMp285&) = delete;

  [[nodiscard]] const std::string& port() const { return port_; }
  [[nodiscard]] Steps at() const {
    const std::lock_guard lock(mutex_);
    return at_;
  }
  // As by the hand wheel.
  void Place(const Steps& at) {
    const std::lock_guard lock(mutex_);
    at_ = at;
  }
  void set_mute(bool is_mute) { mute_ = is_mute; }
  [[nodiscard]] int failures() const { return failures_; }

 private:
  static constexpr int kFailures = 6;

  void Run(const std::stop_token& stop) {
    std::string came;
    while (!stop.stop_requested()) {
      pollfd ready{line_, POLLIN, 0};
      if (poll(&ready, 1, 20) <= 0) continue;
      char buffer[64];
      const ssize_t got = read(line_, buffer, sizeof buffer);
      if (got <= 0) continue;
      came.append(buffer, static_cast<std::size_t>(got));
      while (Obey(&came)) {
      }
    }
  }
  // Whether a whole command was there.
  bool Obey(std::string* came) {
    if (came->empty()) return false;
    const std::size_t length = came->front() == 'm' ? 14 : came->front() == 'c' ? 2 : 1;
    if (came->size() < length) return false;
    const std::string command = came->substr(0, length);
    came->erase(0, length);
    if (command.front() == '\x03') {
      Answer("\r");
    } else if (command.front() == 'c') {
      Answer(Bytes() + '\r');
    } else if (command.front() == 'm') {
      Move(command);
    } else {
      Answer("4\r");
    }
    return true;
  }
  void Move(const std::string& command) {
    Steps to{};
    for (std::size_t i = 0; i < 12; ++i) {
      to[i / 4] |= static_cast<std::int32_t>(static_cast<unsigned char>(command[1 + i]))
                   << 8 * (i % 4);
    }
    // It may stop on its way, and says so.
    if (failing_ > 0 && Chance(1)) {
      ++failures_;
      Place({(at()[0] + to[0]) / 2, (at()[1] + to[1]) / 2, (at()[2] + to[2]) / 2});
      return Send("8\r");
    }
    Place(to);
    Answer("\r");
  }
  std::string Bytes() {
    std::string bytes;
    for (const auto axis : at()) {
      for (int k = 0; k < 4; ++k) bytes += static_cast<char>(axis >> 8 * k);
    }
    return bytes;
  }
  bool Chance(int percent) { return static_cast<int>(random_() % 100) < percent; }
  // What comes out of a line: most of the time, the answer.
  void Answer(std::string bytes) {
    Send(std::exchange(late_, ""));
    if (mute_) return;
    if (!Chance(failing_)) return Send(bytes);
    ++failures_;
    switch (random_() % kFailures) {
      case 0:
        return;  // nothing
      case 1:
        return Send(bytes.substr(0, bytes.size() / 2));  // half of it
      case 2:
        bytes[random_() % bytes.size()] ^= static_cast<char>(1U << random_() % 8);  // a bit
        return Send(bytes);
      case 3:
        return Send("\x7f\x11" + bytes);  // garbage before it
      case 4:
        late_ = bytes;  // with the next one
        return;
      default:
        return Send(std::string(1, "0124"[random_() % 4]) + '\r');  // an error of its own
    }
  }
  void Send(const std::string& bytes) {
    if (!bytes.empty() && write(line_, bytes.data(), bytes.size()) < 0) return;
  }

  const int failing_;  // [%]
  std::mt19937 random_;
  const int line_;
  int kept_ = -1;
  std::string port_, late_;
  std::atomic<bool> mute_{false};
  std::atomic<int> failures_{0};
  mutable std::mutex mutex_;  // guards the next one
  Steps at_{200'000, 200'000, 200'000};
  std::jthread thread_;  // last
};

}  // namespace palpate
