#include "slave/pipeline/teleop/stop_record.h"

#include <algorithm>
#include <exception>
#include <stdexcept>

#include <spdlog/spdlog.h>

#include "shared/text/text.h"

namespace palpate {
namespace {

constexpr std::size_t kLongestReason = 200;    // [characters]
constexpr std::uintmax_t kLargestFile = 4096;  // [bytes]

// What somebody else left in the file is a reason, too.
std::string KeptReason(const std::filesystem::path& file) {
  try {
    return Shown(Trimmed(ReadWholeFile(file, kLargestFile, "a reason")), kLongestReason);
  } catch (const std::exception&) {
    return {};
  }
}

std::chrono::system_clock::time_point WrittenAt(const std::filesystem::path& file) {
  std::error_code none;
  const auto at = std::filesystem::last_write_time(file, none);
  return none ? std::chrono::system_clock::now()
              : std::chrono::time_point_cast<std::chrono::system_clock::duration>(
                    std::chrono::file_clock::to_sys(at));
}

std::string Span(std::chrono::system_clock::duration span) {
  constexpr long kMinute = 60, kHour = 3600;
  const long s =
      std::max(0L, static_cast<long>(std::chrono::floor<std::chrono::seconds>(span).count()));
  if (s < 2 * kMinute) return std::to_string(s) + " s";
  return s < 2 * kHour ? std::to_string(s / kMinute) + " min" : std::to_string(s / kHour) + " h";
}

}  // namespace

bool StopRecord::KeepIn(const std::filesystem::path& folder) {
  file_ = folder / "emergency-stop";
  if (std::filesystem::exists(file_) && !std::filesystem::is_regular_file(file_)) {
    throw std::runtime_error(file_.string() +
                             ": an emergency stop is kept there, accepted is a file");
  }
  RequireWritable(file_);
  if (!std::filesystem::exists(file_)) return false;
  const std::scoped_lock lock(mutex_);
  stands_ = true;
  reason_ = KeptReason(file_);
  reason_ += reason_.empty() ? "from before the start" : ", from before the start";
  since_ = WrittenAt(file_);
  spdlog::warn("emergency stop: {}", reason_);
  return true;
}

std::string StopRecord::Begin(const std::string& reason) noexcept {
  try {
    const std::string shown = Shown(reason, kLongestReason);
    spdlog::warn("emergency stop: {}", shown);
    const std::scoped_lock lock(mutex_);
    stands_ = true;
    reason_ = shown;
    since_ = Clock::now();
    if (!file_.empty()) ReplaceFile(file_, shown + "\n");
    return {};
  } catch (const std::exception& error) {
    return std::string("the emergency stop will not outlive this process: ") + error.what();
  }
}

void StopRecord::End() {
  const std::scoped_lock lock(mutex_);
  if (!file_.empty()) std::filesystem::remove(file_);
  stands_ = false;
}

std::string StopRecord::Words() const {
  const std::scoped_lock lock(mutex_);
  if (!stands_) return {};
  return "emergency stop for " + Span(Clock::now() - since_) +
         (reason_.empty() ? "" : ": " + reason_);
}

}  // namespace palpate
