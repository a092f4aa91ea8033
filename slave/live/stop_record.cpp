#include "slave/live/stop_record.h"

#include <algorithm>
#include <cstdio>
#include <exception>
#include <stdexcept>

#include <fcntl.h>
#include <spdlog/spdlog.h>
#include <unistd.h>

#include "shared/text/text.h"

namespace palpate {
namespace {

constexpr std::size_t kMaxReasonLength = 200;  // [characters]
constexpr std::uintmax_t kMaxFile = 4096;      // [bytes]

// Any text that another program left in the file counts as a reason, too.
std::string KeptReason(const std::filesystem::path& file) {
  try {
    return Shown(Trimmed(ReadWholeFile(file, kMaxFile, "a reason")), kMaxReasonLength);
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

// Writes the directory entries of a folder to the disk.
bool SyncFolder(const std::filesystem::path& folder) {
  const int opened = open(folder.c_str(), O_RDONLY | O_CLOEXEC);
  if (opened < 0) return false;
  const bool done = fsync(opened) == 0;
  return close(opened) == 0 && done;
}

// Writes a file and waits until it is on the disk, because power may be cut after an emergency
// stop.
void KeepFile(const std::filesystem::path& file, const std::string& text) {
  const auto write = [&](std::FILE* out) {
    return std::fputs(text.c_str(), out) >= 0 && std::fflush(out) == 0 && fsync(fileno(out)) == 0;
  };
  const std::filesystem::path folder = file.has_parent_path() ? file.parent_path() : ".";
  if (TryReplace(file, write, Links::kReplace) && SyncFolder(folder)) return;
  throw std::runtime_error(file.string() + ": cannot be written");
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
  const auto kept = std::filesystem::symlink_status(file_);
  if (std::filesystem::exists(kept) && !std::filesystem::is_regular_file(kept)) {
    throw std::runtime_error(file_.string() +
                             ": expected a regular file that keeps an emergency stop");
  }
  RequireWritable(file_);
  if (!std::filesystem::exists(kept)) {
    KeepFile(file_, "to be kept\n");  // a file can be opened even if the disk is full
    std::filesystem::remove(file_);
    trying_ = std::jthread([this](const std::stop_token& stop) { KeepTrying(stop); });
    return false;
  }
  const std::scoped_lock lock(mutex_);
  is_active_ = true;
  reason_ = KeptReason(file_);
  reason_ += reason_.empty() ? "from before the start" : ", from before the start";
  since_ = WrittenAt(file_);
  spdlog::warn("emergency stop: {}", reason_);
  trying_ = std::jthread([this](const std::stop_token& stop) { KeepTrying(stop); });
  return true;
}

std::string StopRecord::Begin(const std::string& reason) noexcept {
  const std::scoped_lock file_lock(file_mutex_);
  try {
    const std::string shown = Shown(reason, kMaxReasonLength);
    spdlog::warn("emergency stop: {}", shown);
    {
      const std::scoped_lock lock(mutex_);
      is_active_ = true;
      reason_ = shown;
      since_ = Clock::now();
    }
    if (file_.empty()) return {};
    is_kept_ = false;
    KeepFile(file_, shown + "\n");
    is_kept_ = true;
    return {};
  } catch (const std::exception& error) {
    changed_.notify_all();
    return std::string("the emergency stop is not saved and would be lost at a restart: ") +
           error.what();
  }
}

void StopRecord::KeepTrying(const std::stop_token& stop) {
  std::unique_lock file_lock(file_mutex_);
  while (changed_.wait(file_lock, stop, [this] { return !is_kept_; })) {
    changed_.wait_for(file_lock, stop, again_, [this] { return is_kept_; });
    if (stop.stop_requested()) return;
    if (is_kept_) continue;
    try {
      KeepFile(file_, Reason() + "\n");
      is_kept_ = true;
      spdlog::warn("the emergency stop is now saved: {}", file_.string());
    } catch (const std::exception&) {  // the error was reported, and writing is repeated
    }
  }
}

void StopRecord::End() {
  const std::scoped_lock file_lock(file_mutex_);
  std::error_code error;
  if (!file_.empty()) std::filesystem::remove(file_, error);
  // If the record could not be written, there is none to remove.
  if (error && std::filesystem::exists(std::filesystem::symlink_status(file_))) {
    throw std::filesystem::filesystem_error("the emergency stop stays", file_, error);
  }
  is_kept_ = true;
  const std::scoped_lock lock(mutex_);
  is_active_ = false;
}

bool StopRecord::is_active() const {
  const std::scoped_lock lock(mutex_);
  return is_active_;
}

std::string StopRecord::Reason() const {
  const std::scoped_lock lock(mutex_);
  return reason_;
}

std::string StopRecord::Words() const {
  const std::scoped_lock lock(mutex_);
  if (!is_active_) return {};
  return "emergency stop for " + Span(Clock::now() - since_) +
         (reason_.empty() ? "" : ": " + reason_);
}

}  // namespace palpate
