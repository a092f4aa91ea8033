#include "master/doctor/doctor.h"

#include <algorithm>
#include <cstdio>
#include <exception>
#include <fstream>
#include <iterator>
#include <set>
#include <string>
#include <system_error>
#include <thread>

#include "master/device/device.h"
#include "master/doctor/link_check.h"
#include "shared/link/thread_priority.h"
#include "shared/text/text.h"

namespace palpate {
namespace {

constexpr int kDone = 0, kFailed = 1;

Finding ExamineDevice(const std::string& spec) {
  if (spec.empty()) return {Grade::kGood, "device", "none was examined: --device names one", ""};
  try {
    return FoundOf(*OpenDevice(spec, 0.005, 0.02));
  } catch (const std::exception& error) {
    return {Grade::kBad, "device", error.what(), "choose one of these with --device"};
  }
}

void Append(Findings more, Findings* findings) {
  std::move(more.begin(), more.end(), std::back_inserter(*findings));
}

void Print(const Finding& finding) {
  constexpr const char* kWords[] = {"good", "note", "BAD "};
  std::printf("%s  %-18s %s\n", kWords[static_cast<int>(finding.grade)], finding.what.c_str(),
              finding.measured.c_str());
  if (!finding.advice.empty()) std::printf("      %-18s -> %s\n", "", finding.advice.c_str());
}

// A force this late is perceived as roughness; a delay of a tenth of a period is not.
constexpr double kNoticedUs = 100, kPerceivedUs = 500;  // 99th percentile of wake-up delays [us]
constexpr double kMissedShare = 1e-3;                   // of all periods

constexpr const char* kLimits =
    "allow it to this user: in /etc/security/limits.d/palpate.conf `USER - rtprio 90` and "
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
    return {Grade::kNote, "governor", "the frequency governor of the processors is unknown", ""};
  }
  std::string names;
  for (const std::string& name : governors) names += (names.empty() ? "" : ", ") + name;
  if (governors == std::set<std::string>{"performance"})
    return {Grade::kGood, "governor", names, ""};
  return {Grade::kNote, "governor", "processors are governed by " + names,
          "as root: cpupower frequency-set -g performance, for punctual wake-ups"};
}

Finding ClockOf(const std::filesystem::path& sys) {
  const std::string clock =
      FirstWord(sys / "devices/system/clocksource/clocksource0/current_clocksource");
  const bool is_quick =
      clock.empty() || clock == "tsc" || clock == "kvm-clock" || clock == "arch_sys_counter";
  return {is_quick ? Grade::kGood : Grade::kNote, "clock",
          clock.empty() ? "the clock source is unknown" : clock,
          is_quick ? "" : "this clock is slow to read: boot with clocksource=tsc if it is stable"};
}

Finding Allowed(const char* what, const std::string& refused) {
  if (refused.empty()) return {Grade::kGood, what, "allowed", ""};
  return {Grade::kNote, what, refused, kLimits};
}

}  // namespace

Finding FoundOf(const Device& device) {
  return {Grade::kGood, "device",
          device.description() + Formatted(", force up to %g N", device.limits().force), ""};
}

Findings Examine(Finding device, const std::optional<SlaveLink::Options>& line, double seconds,
                 const std::stop_token& stop) {
  Findings findings = ExamineTimer(seconds, stop);
  Append(ExamineProcessors(), &findings);
  findings.push_back(std::move(device));
  if (line && !stop.stop_requested()) Append(ExamineLink(*line, seconds, stop), &findings);
  std::ranges::stable_sort(findings, {}, &Finding::grade);
  return findings;
}

int RunDoctor(const DoctorOptions& options) {
  const Findings findings = Examine(ExamineDevice(options.device), options.line, options.seconds);
  std::ranges::for_each(findings, Print);
  const bool is_bad = !findings.empty() && findings.back().grade == Grade::kBad;
  std::puts(is_bad ? "not ready: correct what is marked BAD" : "ready to operate");
  return is_bad ? kFailed : kDone;
}

Finding CheckTimer(const PeriodicStats& bare) {
  const double p99 = bare.wake_us.Quantile(0.99);
  const auto periods = static_cast<double>(bare.ticks + bare.missed);
  const bool misses = static_cast<double>(bare.missed) > kMissedShare * periods;
  Finding finding{Grade::kGood, "timer", "", ""};
  finding.measured = Formatted(
      "1 kHz for %.1f s: wake-up delay median %.0f us, 99 %% below %.0f us, maximum %.0f us; "
      "%llu periods missed",
      bare.duration, bare.wake_us.Quantile(0.5), p99, bare.wake_us.max(),
      static_cast<unsigned long long>(bare.missed));
  if (p99 > kNoticedUs || bare.missed > 0) finding.grade = Grade::kNote;
  if (p99 > kPerceivedUs || misses) finding.grade = Grade::kBad;
  if (finding.grade != Grade::kGood) {
    finding.advice =
        "stop other programs, allow real-time priority, and see `governor`: late ticks make the "
        "force rough";
  }
  return finding;
}

Findings ExamineTimer(double seconds, const std::stop_token& stop) {
  std::string priority;
  PeriodicStats bare;
  // A separate thread, so that the caller keeps its priority.
  std::jthread([&] {
    priority = MakeThreadRealtime(kHapticPriority);
    RunPeriodically(Seconds(seconds), stop, &bare, [] { return true; });
  }).join();
  return {CheckTimer(bare), Allowed("real-time priority", priority),
          Allowed("locked memory", LockMemory())};
}

Findings ExamineProcessors(const std::filesystem::path& sys) {
  const unsigned cores = std::thread::hardware_concurrency();
  Finding count{Grade::kGood, "processors", Formatted("%u", cores), ""};
  if (cores < 2) {
    count.grade = Grade::kBad;
    count.advice = "at least 2 are needed: one for the haptic loop, one for the link";
  }
  return {count, Pace(sys), ClockOf(sys)};
}

}  // namespace palpate
