#include "slave/commands/process.h"

#include <cstdio>
#include <map>
#include <stdexcept>
#include <string>

#include <spdlog/fmt/fmt.h>
#include <unistd.h>

#include "shared/text/text.h"
#include "slave/pipeline/camera/offline_run.h"
#include "slave/pipeline/fingertips/tactile_run.h"
#include "slave/pipeline/points/stereo_run.h"
#include "slave/scene/scene_loader.h"

namespace palpate {
namespace {

void PrintStage(const char* name, const LatencyHistogram& h) {
  fmt::print("  {:<10} {:>9.1f} {:>9.1f} {:>9.1f}\n", name, h.Quantile(0.5), h.Quantile(0.99),
             h.max());
}

// `what`: pictures, pairs or samples.
void PrintPace(const RunSummary& s, const char* what) {
  fmt::print("{} {} in {:.2f} s: {:.0f} {}/s\n", s.frames, what, s.seconds, s.rate(), what);
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

void PrintBudget(const ErrorBudget& budget, const char* what) {
  if (budget.count() == 0) return;
  const double peak = budget.peak_force();
  fmt::print(
      "force error over {} {} in contact, true peak {:.4g} N: rms {:.3g} N ({:.2f} % of the peak); "
      "from the model {:.2f} %, from tracking {:.2f} %\n",
      budget.count(), what, peak, budget.rms(), 100 * budget.rms() / peak,
      100 * budget.model_rms() / peak, 100 * budget.tracking_rms() / peak);
}

void Print(const OfflineSummary& s, const std::filesystem::path& out) {
  PrintPace(s, "pictures");
  PrintStage("vision", s.times.vision);
  PrintStage("contact", s.times.contact);
  PrintStage("mechanics", s.times.mechanics);
  PrintValidity(s.validity);
  if (s.has_truth) PrintBudget(s.budget, "pictures");
  PrintWritten(out);
}

// What the steps of paper C's figures 5 and 6 came to.
void PrintSteps(const std::vector<PressStep>& steps) {
  if (steps.empty()) return;
  fmt::print("  {:>10} {:>12} {:>13} {:>12} {:>7} {:>21}\n", "depth [mm]", "true [N]",
             "estimated [N]", "worst [N]", "[%]", "worst point [mm]");
  for (const PressStep& step : steps) {
    const double share = step.true_force > 0 ? 100 * step.force_error / step.true_force : 0;
    fmt::print("  {:>10.2f} {:>12.4f} {:>13.4f} {:>12.4f} {:>7.1f} {:>21.3f}\n", 1e3 * step.depth,
               step.true_force, step.force, step.force_error, share,
               1e3 * step.displacement.peak());
  }
}

void PrintPoints(const ErrorOfPoints& error, const char* what) {
  if (error.count() == 0) return;
  fmt::print("{}: rms {:.3f} mm, largest {:.3f} mm, over {} places\n", what, 1e3 * error.rms(),
             1e3 * error.peak(), error.count());
}

void Print(const StereoSummary& s, const std::filesystem::path& out) {
  PrintPace(s, "pairs");
  PrintStage(s.eyes.c_str(), s.look);
  PrintStage("mechanics", s.mechanics);
  PrintStage("total", s.total);
  PrintValidity(s.validity);
  for (const auto& [why, count] : s.reasons) fmt::print("  {} times: {}\n", count, why);
  fmt::print("{} of {} points followed, {} never seen; {} times one of those followed was not\n",
             s.points_followed, s.points, s.points - s.points_followed, s.points_unseen);
  if (s.has_truth) PrintBudget(s.budget, "pairs");
  PrintPoints(s.displacement, "error of the points' displacements");
  PrintPoints(s.place, "error of the points' places since the first pair");
  PrintSteps(s.steps);
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

// The keys that make a recording of the frames just written.
void PrintFrames(const Scene& scene, const std::filesystem::path& out) {
  if (!scene.sense.stereo) return;
  const auto folder = std::filesystem::absolute(out / "frames");
  fmt::print(
      "to process them again:\n  sense.camera={{stereo: {{left: \"{0}/left/*.png\", right: "
      "\"{0}/right/*.png\", rig: \"{0}/rig.yaml\"}}, rate: {1:g} Hz, {2}}}\n",
      folder.string(), scene.sense.stereo->rate, ScenePose(scene.sense.stereo->X_SL));
}

void RefusePictures(const ProcessOptions& options, const Scene& scene) {
  if (!options.pictures && !options.frames) return;
  throw std::invalid_argument(std::string(options.pictures ? "--pictures" : "--frames") + ": " +
                              scene.file.string() + " has no camera");
}

// Of --duration; 0: not asked for.
double Duration(const ProcessOptions& options, const Scene& scene) {
  constexpr double kLongest = 86400;  // [s]
  if (!options.duration) return 0;
  const double duration = *options.duration;
  if (!(duration > 0 && duration <= kLongest)) {
    throw std::invalid_argument(
        fmt::format("--duration = {:g}: accepted is 0 < seconds <= {:g}", duration, kLongest));
  }
  if (!HasEyes(scene.sense)) {
    throw std::invalid_argument(
        fmt::format("--duration: accepted for a simulated target that goes on; {} has none",
                    scene.file.string()));
  }
  return duration;
}

}  // namespace

int RunProcess(const ProcessOptions& options, const std::stop_token& stop) {
  const Scene scene = LoadScene(options.scene, options.overrides);
  const auto inputs = InputFilesOf(scene);
  RequireOtherThan("--out", options.out, {"states.csv", "summary.json"}, inputs);
  if (options.pictures) RequireOtherThan("--pictures", options.out, {"pictures"}, inputs);
  if (options.frames) {
    RequireOtherThan("--frames", options.out,
                     {"frames", "frames/left", "frames/right", "frames/rig.yaml"}, inputs);
  }
  const double duration = Duration(options, scene);
  const bool terminal = isatty(STDERR_FILENO) != 0;
  const bool has_eyes = HasEyes(scene.sense);
  const char* what = scene.sense.tactile ? "samples" : has_eyes ? "pairs" : "pictures";
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
  } else if (has_eyes) {
    finish(RunStereo(scene, {options.out, options.pictures, options.frames, progress, duration},
                     stop));
    if (options.frames) PrintFrames(scene, options.out);
  } else {
    finish(RunOffline(scene, {options.out, options.pictures, options.frames, progress}, stop));
  }
  return 0;
}

}  // namespace palpate
