#include "slave/commands/process.h"

#include <cstdio>
#include <map>
#include <stdexcept>
#include <string>

#include <spdlog/fmt/fmt.h>
#include <unistd.h>

#include "shared/scene/scene_loader.h"
#include "slave/pipeline/offline_run.h"
#include "slave/pipeline/tactile_run.h"

namespace palpate {
namespace {

void PrintStage(const char* name, const LatencyHistogram& h) {
  fmt::print("  {:<10} {:>9.1f} {:>9.1f} {:>9.1f}\n", name, h.Quantile(0.5), h.Quantile(0.99),
             h.max());
}

// `what`: pictures or samples.
template <class Summary>
void PrintPace(const Summary& s, const char* what) {
  fmt::print("{} {} in {:.2f} s: {:.0f} {}/s\n", s.frames, what, s.seconds,
             s.seconds > 0 ? static_cast<double>(s.frames) / s.seconds : 0.0, what);
  fmt::print("  {:<10} {:>9} {:>9} {:>9}\n", "step [us]", "median", "99 %", "worst");
  PrintStage("capture", s.capture);
}

void PrintValidity(const std::map<std::string, std::uint64_t>& validity) {
  fmt::print("validity:");
  for (const auto& [name, count] : validity) fmt::print(" {} {}", name, count);
  fmt::print("\n");
}

void PrintWritten(const std::filesystem::path& out) {
  fmt::print("written: {}, {}\n", (out / "states.csv").string(), (out / "summary.json").string());
}

void Print(const OfflineSummary& s, const std::filesystem::path& out) {
  PrintPace(s, "pictures");
  PrintStage("vision", s.times.vision);
  PrintStage("contact", s.times.contact);
  PrintStage("mechanics", s.times.mechanics);
  PrintValidity(s.validity);
  if (s.has_truth && s.budget.count() > 0) {
    const double peak = s.budget.peak_force();
    fmt::print(
        "force error over {} pictures in contact, true peak {:.4g} N: rms {:.3g} N ({:.2f} % of "
        "the peak); from the model {:.2f} %, from tracking {:.2f} %\n",
        s.budget.count(), peak, s.budget.rms(), 100 * s.budget.rms() / peak,
        100 * s.budget.model_rms() / peak, 100 * s.budget.tracking_rms() / peak);
  }
  PrintWritten(out);
}

void Print(const TactileSummary& s, const std::filesystem::path& out) {
  PrintPace(s, "samples");
  PrintStage("tactile", s.times.tactile);
  PrintStage("contact", s.times.contact);
  PrintStage("mechanics", s.times.mechanics);
  PrintStage("total", s.times.total);
  PrintValidity(s.validity);
  if (s.has_truth && s.error.count > 0) {
    fmt::print(
        "force error over {} samples in contact, true peak {:.4g} N: rms {:.3g} N ({:.2f} % of the "
        "peak), largest {:.3g} N; of the contact that the master renders {:.3g} N\n",
        s.error.count, s.error.true_peak, s.error.rms, 100 * s.error.rms / s.error.true_peak,
        s.error.peak, s.error.model_rms);
  }
  PrintWritten(out);
}

void RefusePictures(const ProcessOptions& options, const Scene& scene) {
  if (!options.pictures && !options.frames) return;
  throw std::invalid_argument(std::string(options.pictures ? "--pictures" : "--frames") + ": " +
                              scene.file.string() + " has no camera");
}

}  // namespace

int RunProcess(const ProcessOptions& options, const std::stop_token& stop) {
  const Scene scene = LoadScene(options.scene, options.overrides);
  const bool terminal = isatty(STDERR_FILENO) != 0;
  const char* what = scene.sense.tactile ? "samples" : "pictures";
  const auto progress = [&](std::uint64_t done) {
    if (terminal && done % 50 == 0) fmt::print(stderr, "\r{} {}", done, what);
  };
  const auto finish = [&](const auto& summary) {
    if (terminal) fmt::print(stderr, "\r                    \r");
    Print(summary, options.out);
  };
  if (scene.sense.tactile) {
    RefusePictures(options, scene);
    finish(RunTactile(scene, {options.out, 1, progress}, stop));
  } else {
    finish(RunOffline(scene, {options.out, options.pictures, options.frames, progress}, stop));
  }
  return 0;
}

}  // namespace palpate
