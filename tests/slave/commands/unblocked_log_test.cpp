#include <algorithm>
#include <array>
#include <memory>
#include <string>

#include <fcntl.h>
#include <gmock/gmock.h>
#include <gtest/gtest.h>
#include <spdlog/logger.h>
#include <unistd.h>

#include "slave/commands/program.h"

namespace palpate {
namespace {

using testing::EndsWith;

// A log into a pipe, as of a supervisor that reads when it likes.
class UnblockedLogTest : public testing::Test {
 protected:
  UnblockedLogTest() {
    EXPECT_EQ(pipe(ends_.data()), 0);
    fcntl(ends_[0], F_SETFL, O_NONBLOCK);
    log_ = std::make_unique<spdlog::logger>("log", std::make_shared<UnblockedSink>(ends_[1]));
    log_->set_pattern("%^%l%$ %v");
  }
  ~UnblockedLogTest() override {
    close(ends_[0]);
    close(ends_[1]);
  }
  // Reads all available data.
  std::string Read() {
    std::string all;
    std::array<char, 4096> some{};
    for (ssize_t n = 0; (n = read(ends_[0], some.data(), some.size())) > 0;) {
      all.append(some.data(), static_cast<std::size_t>(n));
    }
    return all;
  }

  std::array<int, 2> ends_{};
  std::unique_ptr<spdlog::logger> log_;
};

// Without it the writer blocks for ever, while it may hold locks.
TEST_F(UnblockedLogTest, UnreadLinesAreLostAndCounted) {
  constexpr int kLines = 20000;
  for (int i = 0; i < kLines; ++i) log_->warn("line {:05d}", i);
  const std::string first = Read();
  EXPECT_THAT(first, EndsWith("\n"));
  const auto kept = std::ranges::count(first, '\n');
  EXPECT_GT(kept, 100);
  EXPECT_LT(kept, kLines);
  log_->warn("somebody reads again");
  EXPECT_EQ(Read(), "warning " + std::to_string(kLines - kept) +
                        " lines of this log are lost: the reader did not keep up\nwarning somebody "
                        "reads again\n");
}

TEST_F(UnblockedLogTest, ALineThatIsTooLongIsShortened) {
  log_->warn(std::string(3 * kMaxUnblocked, 'x'));
  const std::string output = Read();
  EXPECT_EQ(output.size(), kMaxUnblocked);
  EXPECT_THAT(output, EndsWith("...\n"));
}

// Writing into a broken pipe raises SIGPIPE, which would end the program.
TEST_F(UnblockedLogTest, AClosedReaderDoesNotEndTheProgram) {
  close(ends_[0]);
  log_->warn("to nobody");
  ends_[0] = open("/dev/null", O_RDONLY);
}

}  // namespace
}  // namespace palpate
