// Serial protocol of a Sutter MP-285 or MP-225: reads the position and moves the micromanipulator.
// The protocol has no checksum, so each answer is accepted only if it is complete and plausible.
#pragma once

#include <array>
#include <chrono>
#include <cstdint>
#include <optional>
#include <string>
#include <string_view>

namespace palpate {

// Microsteps along the axes of the drive, from the origin that is set at it: of either sign.
using Steps = std::array<std::int32_t, 3>;

// For one thread. After an error, `fault` describes it, nothing moves, and the position is unknown
// until Find succeeds. An unplugged port is opened again by its name.
class Mp285 {
 public:
  static constexpr double kStep = 0.0625e-6;        // [m]
  static constexpr std::int32_t kTravel = 400'000;  // 25 mm
  using Patience = std::chrono::milliseconds;

  // Opens `port` at 9600 baud, 8 bits, no parity. `patience`: longest wait for an answer, in
  // addition to the duration of a move. Throws std::runtime_error: there is no such port, or no
  // permission.
  explicit Mp285(const std::string& port, Patience patience = Patience(250));
  ~Mp285();
  Mp285(const Mp285&) = delete;
  Mp285& operator=(const Mp285&) = delete;

  // Interrupts a move, discards pending data and reads the position twice. False: fault. It is also
  // a fault if the device was silent for longer than four answers take, or unplugged, and is now
  // neither at its last position nor on the way to its target: after a power cycle it uses another
  // origin.
  bool Find();
  // Moves to the position within `takes` and reads the position. False: fault. Positions beyond the
  // travel are rejected.
  bool MoveTo(const Steps& steps, Patience takes);
  // Reads the position. A changed position is accepted only if it is read twice. False: fault.
  bool Poll();

  // Present position; nullopt: unknown.
  [[nodiscard]] const std::optional<Steps>& at() const { return at_; }
  [[nodiscard]] const std::string& fault() const { return fault_; }  // empty: none

 private:
  bool Fail(const std::string& why);
  bool Open();  // false: there is no such port; errno has the reason
  void Close();
  void Lose();  // unplugged: while the descriptor is open, the port would get another name
  bool Know(const Steps& at);
  bool Send(std::string_view bytes);
  // nullopt: no answer in time.
  std::optional<std::string> Read(std::size_t bytes, Patience patience);
  // One answer to `c`; nullopt: no complete answer: fault.
  std::optional<Steps> QuerySteps();
  void Empty();

  const std::string port_;
  const Patience patience_;
  int line_ = -1;  // -1: gone
  std::optional<Steps> at_;
  std::optional<Steps> known_, sent_;  // where it stood last, and where it may have gone since
  std::chrono::steady_clock::time_point heard_at_;  // the last complete position
  bool was_away_ = false;                           // since then
  std::string fault_;
};

}  // namespace palpate
