#include "master/doctor/machine.h"

#include <fstream>
#include <set>
#include <string>
#include <system_error>
#include <thread>

#include "shared/link/thread_priority.h"
#include "shared/text/text.h"

namespace palpate {
namespace {

// A force that comes so late after its tick is felt as roughness; a tenth of a period is not.
constexpr double kNoticedUs = 100, kFeltUs = 500;  // of 99 in 100 wake-ups [us]
constexpr double kMissedShare = 1e-3;              // of all periods

constexpr const char* kLimits =
    "let this user have it: in /etc/security/limits.d/palpate.conf `USER - rtprio 90` and "
    "`USER - memlock unlimited`, then log in again";

std::string FirstWord(const std::filesystem::path& file) {
  std::string word;
  std::ifstream(file) >> word;
  return Presentable(word, 40);
}

std::set<std::string> Governors(const std::filesystem::path& cpus) {
  std::set<std::string> governors;
  std::error_code error;
  for (const auto& cpu : std::filesystem::directory_iterator(cpus, error)) {
    const std::string governor = FirstWord(cpu.path() / "cpufreq" / "scaling_governor");
    if (!governor.empty()) governors.insert(governor);
  }
  return governors;
}

Finding Pace(const std::filesystem::path& sys) {
  const auto governors = Governors(sys / "devices/system/cpu");
  if (governors.empty()) {
    return {Verdict::kNote, "pace", "the system does not tell how its processors are governed", ""};
  }
  std::string names;
  for (const std::string& name : governors) names += (names.empty() ? "" : ", ") + name;
  if (governors == std::set<std::string>{"performance"}) return {Verdict::kGood, "pace", names, ""};
  return {Verdict::kNote, "pace", "processors are governed by " + names,
          "as root: cpupower frequency-set -g performance, for wake-ups that are not late"};
}

Finding ClockOf(const std::filesystem::path& sys) {
  const std::string clock =
      FirstWord(sys / "devices/system/clocksource/clocksource0/current_clocksource");
  const bool is_quick =
      clock.empty() || clock == "tsc" || clock == "kvm-clock" || clock == "arch_sys_counter";
  return {is_quick ? Verdict::kGood : Verdict::kNote, "clock",
          clock.empty() ? "the system does not tell its clock" : clock,
          is_quick ? "" : "this clock is slow to read: boot with clocksource=tsc if it is stable"};
}

Finding Allowed(const char* what, const std::string& refused) {
  if (refused.empty()) return {Verdict::kGood, what, "allowed", ""};
  return {Verdict::kNote, what, refused, kLimits};
}

}  // namespace

Finding CheckTimer(const PeriodicStats& bare) {
  const double p99 = bare.wake_us.Quantile(0.99);
  const auto periods = static_cast<double>(bare.ticks + bare.missed);
  const bool misses = static_cast<double>(bare.missed) > kMissedShare * periods;
  Finding finding{Verdict::kGood, "timer", "", ""};
  finding.measured = Formatted(
      "1 kHz for %.1f s: woken %.0f us late at the median, %.0f us at 99 %%, %.0f us at worst; "
      "%llu "
      "periods missed",
      bare.duration, bare.wake_us.Quantile(0.5), p99, bare.wake_us.max(),
      static_cast<unsigned long long>(bare.missed));
  if (p99 > kNoticedUs || bare.missed > 0) finding.verdict = Verdict::kNote;
  if (p99 > kFeltUs || misses) finding.verdict = Verdict::kBad;
  if (finding.verdict != Verdict::kGood) {
    finding.advice =
        "stop what else runs here, allow real-time priority, and see `pace`: the hand "
        "feels "
        "late ticks as roughness";
  }
  return finding;
}

Findings ExamineTimer(double seconds, const std::stop_token& stop) {
  std::string priority;
  PeriodicStats bare;
  // A thread of its own: the caller stays as it is.
  std::jthread([&] {
    priority = MakeThreadRealtime(kHapticPriority);
    RunPeriodically(Seconds(seconds), stop, &bare, [] { return true; });
  }).join();
  return {CheckTimer(bare), Allowed("real-time priority", priority),
          Allowed("locked memory", LockMemory())};
}

Findings ExamineProcessors(const std::filesystem::path& sys) {
  const unsigned cores = std::thread::hardware_concurrency();
  Finding count{Verdict::kGood, "processors", Formatted("%u", cores), ""};
  if (cores < 2) {
    count.verdict = Verdict::kBad;
    count.advice = "the loop and the link want one each: at least 2";
  }
  return {count, Pace(sys), ClockOf(sys)};
}

}  // namespace palpate
