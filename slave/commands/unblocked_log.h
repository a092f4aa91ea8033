// A log that nobody has to read: a terminal that was stopped, a supervisor that hangs or a pipe
// that is full cost lines, never the time of who says something.
#pragma once

#include <cstddef>
#include <mutex>
#include <string_view>

#include <spdlog/sinks/base_sink.h>

namespace palpate {

// All of `text`, or nothing of it where that might have to wait. At most kMostUnblocked bytes are
// written, so much as a pipe takes in one piece.
bool WriteUnblocked(int fd, std::string_view text);
inline constexpr std::size_t kMostUnblocked = 4096;

// Lines that are lost are counted, and the next one that is not says how many they were.
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
