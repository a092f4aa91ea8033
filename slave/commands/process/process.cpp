#include "slave/commands/process/process.h"

#include <array>
#include <stdexcept>
#include <string>

#include <spdlog/fmt/fmt.h>
#include <unistd.h>

#include "shared/text/text.h"
#include "slave/commands/scene_remarks.h"
#include "slave/live/offline_run.h"
#include "slave/recording/recorded_run.h"
#include "slave/scene/scene_loader.h"

namespace palpate {
namespace {

void RefuseOptions(const ProcessOptions& options) {
  if (options.overrides.empty() && !options.images && !options.frames && !options.points &&
      !options.duration) {
    return;
  }
  throw std::invalid_argument(options.scene.string() +
                              ": with a recording, expected --out only: a recording contains its "
                              "scene, and no images are drawn");
}

// A recording that cannot be used is an unusable argument.
template <class Read>
auto Reading(const Read& read) {
  try {
    return read();
  } catch (const InputError& error) {
    throw std::invalid_argument(error.what());
  }
}

int RunProcessRecording(const ProcessOptions& options, const std::stop_token& stop) {
  RefuseOptions(options);
  const std::array inputs{options.scene};
  RequireOtherThan("--out", options.out, {"states.csv", "summary.json"}, inputs);
  const RecordedRun run =
      Reading([&] { return ProcessRecording(options.scene, options.out, stop); });
  for (const std::string& line : InWords(run)) fmt::print("{}\n", line);
  return 0;
}

void PrintStage(const StageTimes& s) {
  fmt::print("  {:<10} {:>9.1f} {:>9.1f} {:>9.1f}\n", s.stage, s.p50_us, s.p99_us, s.max_us);
}

void PrintPace(const OfflineSummary& s) {
  fmt::print("{} {} in {:.2f} s: {:.0f} {}/s\n", s.frames, s.sense.samples, s.seconds, s.rate(),
             s.sense.samples);
  fmt::print("  {:<10} {:>9} {:>9} {:>9}\n", "step [us]", "median", "99 %", "largest");
  PrintStage(TimesOf("capture", s.capture));
  for (const StageTimes& stage : s.stages) PrintStage(stage);
}

void PrintBudget(const ErrorBudget& budget, const std::string& what) {
  if (budget.count == 0) return;
  const double peak = budget.peak_force;
  fmt::print(
      "force error over {} {} in contact, true peak {:.4g} N: rms {:.3g} N ({:.2f} % of the peak), "
      "largest {:.3g} N; due to the model {:.2f} %, due to tracking {:.2f} %\n",
      budget.count, what, peak, budget.rms, 100 * budget.rms / peak, budget.peak_error,
      100 * budget.model_rms / peak, 100 * budget.tracking_rms / peak);
}

void Print(const OfflineSummary& s, const std::filesystem::path& out) {
  for (const std::string& line : Introduction(s.sense)) fmt::print("{}\n", line);
  PrintPace(s);
  fmt::print("validity:");
  for (const auto& [name, count] : s.validity) fmt::print(" {} {}", name, count);
  fmt::print("\n");
  PrintBudget(s.budget, s.sense.samples);
  for (const std::string& line : s.lines) fmt::print("{}\n", line);
  fmt::print("written: {}, {}\n", (out / "states.csv").string(), (out / "summary.json").string());
}

// Prints the scene keys for processing the written frames as a recording.
void PrintFrames(const Scene& scene, const std::filesystem::path& out) {
  if (!scene.sense.Find<StereoCameras>()) return;
  const auto folder = std::filesystem::absolute(out / "frames");
  fmt::print(
      "to process them again:\n  sense.camera={{stereo: {{left: \"{0}/left/*.png\", right: "
      "\"{0}/right/*.png\", rig: \"{0}/rig.yaml\"}}, rate: {1:g} Hz, {2}}}\n",
      folder.string(), scene.sense.Find<StereoCameras>()->rate,
      ScenePose(scene.sense.Find<StereoCameras>()->X_SL));
}

void RefuseImages(const ProcessOptions& options, const Scene& scene) {
  if (!options.images && !options.frames) return;
  throw std::invalid_argument(std::string(options.images ? "--images" : "--frames") + ": " +
                              scene.file.string() + " has no camera");
}

// The value of --duration [s]; 0: absent.
double Duration(const ProcessOptions& options, const Scene& scene) {
  constexpr double kMaxDuration = 86400;  // [s]
  if (!options.duration) return 0;
  const double duration = *options.duration;
  if (!(duration > 0 && duration <= kMaxDuration)) {
    throw std::invalid_argument(
        fmt::format("--duration = {:g}: expected 0 < seconds <= {:g}", duration, kMaxDuration));
  }
  if (!HasStereoOrDepth(scene.sense)) {
    throw std::invalid_argument(
        fmt::format("--duration: only for a simulated target that moves on a path; {} has none",
                    scene.file.string()));
  }
  return duration;
}

}  // namespace

int RunProcess(const ProcessOptions& options, const std::stop_token& stop) {
  if (options.scene.extension() == ".mcap") return RunProcessRecording(options, stop);
  const Scene scene = LoadRunningScene(options.scene, options.overrides);
  const auto inputs = InputFilesOf(scene);
  RequireOtherThan("--out", options.out, {"states.csv", "summary.json"}, inputs);
  if (options.images) RequireOtherThan("--images", options.out, {"images"}, inputs);
  if (options.frames) {
    RequireOtherThan("--frames", options.out,
                     {"frames", "frames/left", "frames/right", "frames/rig.yaml"}, inputs);
  }
  if (options.points) RequireOtherThan("--points", options.out, {"points.csv"}, inputs);
  const double duration = Duration(options, scene);
  if (!HasImages(scene.sense)) RefuseImages(options, scene);
  const bool terminal = isatty(STDERR_FILENO) != 0;
  const auto progress = [&](std::uint64_t done) {
    if (terminal && done % 50 == 0) fmt::print(stderr, "\r{}", done);
  };
  const OfflineSummary summary = RunOffline(
      scene, {options.out, options.images, options.frames, progress, duration, options.points},
      stop);
  if (terminal) fmt::print(stderr, "\r                    \r");
  Print(summary, options.out);
  if (options.frames) PrintFrames(scene, options.out);
  return 0;
}

}  // namespace palpate
