#include "master/doctor/doctor.h"

#include <algorithm>
#include <cstdio>
#include <exception>
#include <iterator>

#include "master/device/device.h"
#include "master/doctor/line.h"
#include "master/doctor/machine.h"
#include "shared/text/text.h"

namespace palpate {
namespace {

constexpr int kDone = 0, kFailed = 1;

Finding ExamineDevice(const std::string& spec) {
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

}  // namespace

Finding FoundOf(const Device& device) {
  return {Grade::kGood, "device",
          device.description() + Formatted(", force up to %g N", device.force_limit()), ""};
}

Findings Examine(Finding device, const std::optional<SlaveLink::Options>& line, double seconds,
                 const std::stop_token& stop) {
  Findings findings = ExamineTimer(seconds, stop);
  Append(ExamineProcessors(), &findings);
  findings.push_back(std::move(device));
  if (line && !stop.stop_requested()) Append(ExamineLine(*line, seconds, stop), &findings);
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

}  // namespace palpate
