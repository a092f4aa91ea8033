#include "slave/commands/process.h"

#include <cstdio>

#include <spdlog/fmt/fmt.h>
#include <unistd.h>

#include "shared/scene/scene_loader.h"
#include "slave/pipeline/offline_run.h"

namespace palpate {
namespace {

void Print(const OfflineSummary& s, const std::filesystem::path& out) {
  const auto stage = [](const char* name, const LatencyHistogram& h) {
    fmt::print("  {:<10} {:>9.1f} {:>9.1f} {:>9.1f}\n", name, h.Quantile(0.5), h.Quantile(0.99),
               h.max());
  };
  fmt::print("{} pictures in {:.2f} s: {:.0f} pictures/s\n", s.frames, s.seconds,
             s.seconds > 0 ? static_cast<double>(s.frames) / s.seconds : 0.0);
  fmt::print("  {:<10} {:>9} {:>9} {:>9}\n", "step [us]", "median", "99 %", "worst");
  stage("capture", s.capture);
  stage("vision", s.times.vision);
  stage("contact", s.times.contact);
  stage("mechanics", s.times.mechanics);
  fmt::print("validity:");
  for (const auto& [name, count] : s.validity) fmt::print(" {} {}", name, count);
  fmt::print("\n");
  if (s.has_truth && s.budget.count() > 0) {
    const double peak = s.budget.peak_force();
    fmt::print(
        "force error over {} pictures in contact, true peak {:.4g} N: rms {:.3g} N ({:.2f} % of "
        "the peak); from the model {:.2f} %, from tracking {:.2f} %\n",
        s.budget.count(), peak, s.budget.rms(), 100 * s.budget.rms() / peak,
        100 * s.budget.model_rms() / peak, 100 * s.budget.tracking_rms() / peak);
  }
  fmt::print("written: {}, {}\n", (out / "states.csv").string(), (out / "summary.json").string());
}

}  // namespace

int RunProcess(const ProcessOptions& options, const std::stop_token& stop) {
  const Scene scene = LoadScene(options.scene, options.overrides);
  const bool terminal = isatty(STDERR_FILENO) != 0;
  const auto progress = [](std::uint64_t done) {
    if (done % 50 == 0) fmt::print(stderr, "\r{} pictures", done);
  };
  OfflineOptions run{options.out, options.pictures, options.frames, nullptr};
  if (terminal) run.progress = progress;
  const OfflineSummary summary = RunOffline(scene, run, stop);
  if (terminal) fmt::print(stderr, "\r                    \r");
  Print(summary, options.out);
  return 0;
}

}  // namespace palpate
