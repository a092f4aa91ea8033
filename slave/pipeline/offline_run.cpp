#include "slave/pipeline/offline_run.h"

#include <cmath>
#include <fstream>
#include <stdexcept>

#include <nlohmann/json.hpp>
#include <spdlog/fmt/fmt.h>

#include "slave/capture/jpeg.h"
#include "slave/capture/picture_files.h"
#include "slave/pipeline/overlay.h"
#include "slave/pipeline/states_file.h"
#include "slave/site/scripted_camera.h"

namespace palpate {
namespace {

constexpr double kContactShare = 0.01;  // of the peak: below it a picture does not count as contact

StateRow RowOf(const Felt& felt, Time start, const SiteTruth* truth) {
  StateRow row{SecondsBetween(start, felt.sensed_at),
               felt.sequence,
               "",
               felt.p_S_tip,
               felt.p_S_contact,
               felt.force,
               felt.sigma,
               felt.validity,
               std::nullopt};
  if (truth != nullptr) row.true_force = truth->force;
  return row;
}

void WriteFrame(const std::filesystem::path& folder, const Frame& frame) {
  const std::filesystem::path file = folder / fmt::format("{:06}.png", frame.sequence);
  RequireWritten(WritePng(frame.image, file), file);
}

void WritePicture(const std::filesystem::path& folder, const Frame& frame,
                  const Estimator& estimator, const Scene& scene) {
  const Observation& seen = estimator.observation();
  const Felt& felt = estimator.felt();
  Overlay overlay{{seen.contour_I.begin(), seen.contour_I.end()},
                  estimator.eyes().search_window(),
                  seen.tip,
                  felt.force,
                  {0, 0}};
  if (felt.force) {
    const OperatorOptions& hand = scene.operator_options;
    overlay.force_I = ForceArrow(estimator.view(), felt.p_S_tip, *felt.force,
                                 hand.force_limit / hand.transform.force_scale, frame.image.rows);
  }
  const std::string jpeg = EncodeJpeg(DrawOverlay(frame.image, overlay), 90);
  const std::filesystem::path file = folder / fmt::format("{:06}.jpg", frame.sequence);
  RequireWritten((std::ofstream(file, std::ios::binary) << jpeg << std::flush).good(), file);
}

// Forces of one picture at a site that knows the truth [N].
struct Compared {
  double estimated, model_at_truth, truth;
};

void WriteSummary(const OfflineSummary& s, const Scene& scene, const std::filesystem::path& file) {
  nlohmann::ordered_json json;
  json["scene"] = scene.name;
  json["frames"] = s.frames;
  json["fps"] = s.seconds > 0 ? static_cast<double>(s.frames) / s.seconds : 0;
  json["stages"] = {{"capture", StageJson(s.capture)},
                    {"vision", StageJson(s.times.vision)},
                    {"contact", StageJson(s.times.contact)},
                    {"mechanics", StageJson(s.times.mechanics)},
                    {"total", StageJson(s.times.total)}};
  json["tracking_lost"] = s.tracking_lost;
  json["force_error"] = nullptr;
  if (s.has_truth) {
    json["force_error"] = {{"rms_N", s.budget.rms()},
                           {"peak_N", s.budget.peak_error()},
                           {"contact_frames", s.budget.count()},
                           {"true_peak_N", s.budget.peak_force()},
                           {"model_rms_N", s.budget.model_rms()},
                           {"tracking_rms_N", s.budget.tracking_rms()}};
  }
  json["validity"] = s.validity;
  json["model"] = {{"kind", s.model.kind},
                   {"elements", s.model.elements},
                   {"dof", s.model.dof},
                   {"precompute_s", s.model.precompute_s}};
  json["rest_surface"] = {{"measured", s.registration.measured},
                          {"rms_px", s.registration.rms_px},
                          {"points", s.registration.points}};
  RequireWritten((std::ofstream(file) << json.dump(2) << "\n" << std::flush).good(), file);
}

// What is written picture by picture.
class Output {
 public:
  Output(const OfflineOptions& options, bool has_truth)
      : options_(options),
        states_(options.out, has_truth),
        pictures_(options.out / "pictures"),
        frames_(options.out / "frames") {
    if (options.pictures) std::filesystem::create_directories(pictures_);
    if (options.frames) std::filesystem::create_directories(frames_);
  }

  void Write(const Scene& scene, const Frame& frame, const Estimator& estimator,
             const SiteTruth* truth) {
    if (frame.sequence == 1) start_ = frame.sensed_at;
    states_.Write(RowOf(estimator.felt(), start_, truth));
    if (options_.frames) WriteFrame(frames_, frame);
    if (options_.pictures) WritePicture(pictures_, frame, estimator, scene);
  }

 private:
  const OfflineOptions& options_;
  StatesFile states_;
  const std::filesystem::path pictures_, frames_;
  Time start_{};
};

// Pictures in contact, by the truth or by the estimate; unknown forces cannot be compared.
ErrorBudget BudgetOf(const std::vector<Compared>& compared) {
  ErrorBudget budget;
  double peak = 0;
  for (const Compared& c : compared) peak = std::fmax(peak, c.truth);
  for (const Compared& c : compared) {
    const bool contact = c.truth > kContactShare * peak || c.estimated > kContactShare * peak;
    if (contact && std::isfinite(c.estimated)) budget.Add(c.estimated, c.model_at_truth, c.truth);
  }
  return budget;
}

Compared Compare(const Felt& felt, const SiteTruth& truth) {
  const LocalModel& local = felt.local_model;
  return {felt.force ? felt.force->norm() : std::nan(""),
          (local.stiffness * local.normal * truth.depth).norm(), truth.force.norm()};
}

void Count(const Felt& felt, OfflineSummary* summary) {
  ++summary->frames;
  ++summary->validity[std::string(ToString(felt.validity))];
  if (felt.validity == Validity::kTrackingLost) ++summary->tracking_lost;
}

// Feels `frame` and all that follow it.
void Feel(const Scene& scene, Frame frame, FrameSource* source, const ScriptedCamera* scripted,
          const OfflineOptions& options, const std::stop_token& stop, Output* output,
          OfflineSummary* summary) {
  using Clock = std::chrono::steady_clock;
  // Nobody says where a recorded tool is; without a template it is looked for at its home.
  const bool at_home = scripted != nullptr || scene.sense.tip->template_file.empty();
  Estimator estimator(scene, frame, at_home ? std::optional(scene.manipulator.home) : std::nullopt);
  summary->registration = estimator.registration();
  summary->model = estimator.touch().deformation->info();
  std::vector<Compared> compared;
  const auto began = Clock::now();
  for (std::optional<Frame> next = std::move(frame); next;) {
    const SiteTruth* truth = scripted != nullptr ? &scripted->truth() : nullptr;
    const Felt& felt = estimator.Feel(*next);
    output->Write(scene, *next, estimator, truth);
    Count(felt, summary);
    if (truth != nullptr) compared.push_back(Compare(felt, *truth));
    if (options.progress) options.progress(summary->frames);
    const auto fetch = Clock::now();
    next = source->Next(stop);
    summary->capture.Add(std::chrono::duration<double, std::micro>(Clock::now() - fetch).count());
  }
  summary->seconds = std::chrono::duration<double>(Clock::now() - began).count();
  summary->times = estimator.times();
  summary->budget = BudgetOf(compared);
}

}  // namespace

OfflineSummary RunOffline(const Scene& scene, const OfflineOptions& options,
                          const std::stop_token& stop) {
  OfflineSummary summary;
  summary.has_truth = scene.sense.camera->source == Camera::Source::kSimulated;
  Output output(options, summary.has_truth);
  std::unique_ptr<ScriptedCamera> scripted;
  std::unique_ptr<FrameSource> recorded;
  if (summary.has_truth) {
    scripted = std::make_unique<ScriptedCamera>(scene);
  } else {
    recorded = OpenFrameSource(scene, false);
  }
  FrameSource* source = scripted ? static_cast<FrameSource*>(scripted.get()) : recorded.get();
  std::optional<Frame> first = source->Next(stop);
  if (first) {
    Feel(scene, *std::move(first), source, scripted.get(), options, stop, &output, &summary);
  } else if (!stop.stop_requested()) {
    throw std::runtime_error(source->description() + ": no picture came");
  }
  WriteSummary(summary, scene, options.out / "summary.json");
  return summary;
}

}  // namespace palpate
