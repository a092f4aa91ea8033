// The serial line of a Sutter MP-285 or MP-225: where the micromanipulator is, and moves. Each
// answer is believed only where it is whole and is what it must be; the line has no checksum.
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

// One thread. After whatever goes wrong, `fault` says what, nothing moves, and the place is unknown
// until Find succeeds. A line that is unplugged is opened again by its name.
class Mp285 {
 public:
  static constexpr double kStep = 0.0625e-6;        // [m]
  static constexpr std::int32_t kTravel = 400'000;  // 25 mm
  using Patience = std::chrono::milliseconds;

  // Opens `port` at 9600 baud, 8 bits, no parity. `patience`: for an answer, beyond what a move
  // takes. Throws std::runtime_error: there is no such line, or it is not permitted.
  explicit Mp285(const std::string& port, Patience patience = Patience(250));
  ~Mp285();
  Mp285(const Mp285&) = delete;
  Mp285& operator=(const Mp285&) = delete;

  // Interrupts whatever moves, empties the line and asks twice where it is. False: fault; also
  // where it was silent for longer than four answers take, or unplugged, and is neither where it
  // stood nor on the way to where it was sent: one that was switched off counts from elsewhere.
  bool Find();
  // Goes there, `takes` being how long that takes, and asks where it is. False: fault. Places
  // beyond the travel are refused.
  bool MoveTo(const Steps& steps, Patience takes);
  // Asks where it is; another place than before is believed when it is said twice. False: fault.
  bool Poll();

  // Where it stands; nullopt: not known.
  [[nodiscard]] const std::optional<Steps>& at() const { return at_; }
  [[nodiscard]] const std::string& fault() const { return fault_; }  // empty: none

 private:
  bool Fail(const std::string& why);
  bool Open();  // false: there is no such line; errno says why
  void Close();
  void Lose();  // unplugged: as long as it is held, it would come back under another name
  bool Know(const Steps& at);
  bool Send(std::string_view bytes);
  // nullopt: it did not come in time.
  std::optional<std::string> Read(std::size_t bytes, Patience patience);
  // One answer to `c`; nullopt: none, or not whole: fault.
  std::optional<Steps> QuerySteps();
  void Empty();

  const std::string port_;
  const Patience patience_;
  int line_ = -1;  // -1: gone
  std::optional<Steps> at_;
  std::optional<Steps> known_, sent_;  // where it stood last, and where it may have gone since
  std::chrono::steady_clock::time_point heard_at_;  // its last whole answer
  bool was_away_ = false;                           // since then
  std::string fault_;
};

}  // namespace palpate
