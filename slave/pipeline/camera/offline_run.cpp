#include "slave/pipeline/camera/offline_run.h"

#include <cmath>
#include <fstream>
#include <stdexcept>

#include <nlohmann/json.hpp>
#include <spdlog/fmt/fmt.h>

#include "slave/capture/codecs/codecs.h"
#include "slave/capture/picture_files.h"
#include "slave/pipeline/camera/overlay.h"
#include "slave/pipeline/offline/states_file.h"
#include "slave/site/camera/scripted_camera.h"
#include "slave/vision/stereo/straightening.h"

namespace palpate {
namespace {

void WriteFrame(const std::filesystem::path& folder, const Frame& frame) {
  const std::filesystem::path file = folder / fmt::format("{:06}.png", frame.sequence);
  RequireWritten(WritePng(frame.image, file), file);
}

void WritePicture(const std::filesystem::path& folder, const Frame& frame,
                  const Estimator& estimator, const Scene& scene) {
  const Observation& seen = estimator.observation();
  const ContactEstimate& felt = estimator.felt();
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

void WriteSummary(const OfflineSummary& s, const Scene& scene, const std::filesystem::path& file) {
  nlohmann::ordered_json json = SummaryJson(s, scene.name,
                                            {{"vision", s.times.vision},
                                             {"contact", s.times.contact},
                                             {"mechanics", s.times.mechanics},
                                             {"total", s.times.total}},
                                            s.has_truth ? ToJson(s.budget) : nullptr);
  json["rest_surface"] = {{"measured", s.registration.measured},
                          {"rms_px", s.registration.rms_px},
                          {"points", s.registration.points}};
  WriteJson(json, file);
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
    states_.Write(RowOf(estimator.felt(), start_,
                        truth != nullptr ? std::optional(truth->force) : std::nullopt));
    if (options_.frames) WriteFrame(frames_, frame);
    if (options_.pictures) WritePicture(pictures_, frame, estimator, scene);
  }

 private:
  const OfflineOptions& options_;
  StatesFile states_;
  const std::filesystem::path pictures_, frames_;
  Time start_{};
};

ComparedForces Compare(const ContactEstimate& felt, const SiteTruth& truth) {
  const LocalModel& local = felt.local_model;
  return {felt.force ? felt.force->norm() : std::nan(""),
          (local.stiffness * local.normal * truth.depth).norm(), truth.force.norm()};
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
  std::vector<ComparedForces> compared;
  const auto began = Clock::now();
  for (std::optional<Frame> next = std::move(frame); next;) {
    const SiteTruth* truth = scripted != nullptr ? &scripted->truth() : nullptr;
    const ContactEstimate& felt = estimator.Feel(*next);
    output->Write(scene, *next, estimator, truth);
    ++summary->frames;
    summary->Count(felt.validity);
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
    recorded = OpenFrameSource(scene, false, StraighteningOf(*scene.sense.camera));
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
