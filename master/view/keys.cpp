#include "master/view/keys.h"

#include <array>
#include <optional>
#include <string_view>
#include <utility>

#include <poll.h>
#include <unistd.h>

namespace palpate {
namespace {

constexpr int kPatience = 100;  // between looks whether to end [ms]

// A line of the terminal, or what came of it; empty: none within the patience. nullopt: the
// terminal is gone, and would be found readable for ever.
std::optional<std::string_view> Line(std::array<char, 256>* buffer) {
  pollfd input{STDIN_FILENO, POLLIN, 0};
  if (poll(&input, 1, kPatience) <= 0) return std::string_view();
  if ((input.revents & ~POLLIN) != 0) return std::nullopt;
  const ssize_t size = read(STDIN_FILENO, buffer->data(), buffer->size());
  return size > 0 ? std::string_view(buffer->data(), static_cast<std::size_t>(size))
                  : std::string_view();
}

}  // namespace

// Any other input is the emergency stop.
Keys::Keys(std::function<void()> stop, std::function<void()> reset) {
  if (isatty(STDIN_FILENO) == 0) return;
  thread_ = std::jthread(
      [stop = std::move(stop), reset = std::move(reset)](const std::stop_token& ended) {
        std::array<char, 256> buffer{};
        while (!ended.stop_requested()) {
          const auto line = Line(&buffer);
          if (!line) return;
          if (!line->empty()) (*line == "r\n" ? reset : stop)();
        }
      });
}

}  // namespace palpate
