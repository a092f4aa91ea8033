// A log that never blocks: a stopped terminal, a hanging supervisor or a full pipe loses lines, but
// does not delay the caller.
#pragma once

#include <cstddef>
#include <mutex>
#include <string_view>

#include <spdlog/sinks/base_sink.h>

namespace palpate {

// Writes all of `text`, or nothing if that would block. At most kMostUnblocked bytes, which a pipe
// accepts at once.
bool WriteUnblocked(int fd, std::string_view text);
inline constexpr std::size_t kMostUnblocked = 4096;

// Lost lines are counted, and the next written line reports their number.
class UnblockedSink final : public spdlog::sinks::base_sink<std::mutex> {
 public:
  // Colours levels where `fd` is a terminal.
  explicit UnblockedSink(int fd);

 private:
  void sink_it_(const spdlog::details::log_msg& message) override;
  void flush_() override {}

  int fd_;
  bool colours_;
  std::size_t lost_ = 0;
};

}  // namespace palpate
