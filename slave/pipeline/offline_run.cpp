#include "slave/pipeline/offline_run.h"

#include <cmath>
#include <fstream>
#include <stdexcept>

#include <nlohmann/json.hpp>
#include <spdlog/fmt/fmt.h>

#include "slave/capture/jpeg.h"
#include "slave/pipeline/overlay.h"
#include "slave/site/scripted_camera.h"

namespace palpate {
namespace {

constexpr double kContactShare = 0.01;  // of the peak: below it a picture does not count as contact

std::string Row(const Felt& felt, Time start, const SiteTruth* truth) {
  const auto number = [](double x) { return std::isfinite(x) ? fmt::format("{:.9g}", x) : ""; };
  const Eigen::Vector3d f = felt.force.value_or(Eigen::Vector3d::Constant(std::nan("")));
  const Eigen::Vector3d& tip = felt.p_S_tip;
  const Eigen::Vector3d& place = felt.p_S_contact;
  std::string row = fmt::format(
      "{:.6f},{},,{},{},{},{},{},{},{},{},{},{},{}", SecondsBetween(start, felt.sensed_at),
      felt.sequence, number(tip.x()), number(tip.y()), number(tip.z()), number(place.x()),
      number(place.y()), number(place.z()), number(f.x()), number(f.y()), number(f.z()),
      number(felt.sigma), ToString(felt.validity));
  if (truth != nullptr) {
    row += fmt::format(",{},{},{}", number(truth->force.x()), number(truth->force.y()),
                       number(truth->force.z()));
  }
  return row + "\n";
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
  std::ofstream(folder / fmt::format("{:06}.jpg", frame.sequence), std::ios::binary) << jpeg;
}

nlohmann::ordered_json StageJson(const LatencyHistogram& h) {
  return {{"p50", h.Quantile(0.5)}, {"p99", h.Quantile(0.99)}, {"max", h.max()}};
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
  std::ofstream(file) << json.dump(2) << "\n";
}

}  // namespace

OfflineSummary RunOffline(const Scene& scene, const OfflineOptions& options,
                          const std::stop_token& stop) {
  const std::filesystem::path& out = options.out;
  const std::filesystem::path pictures = out / "pictures";
  std::filesystem::create_directories(options.pictures ? pictures : out);
  std::ofstream states(out / "states.csv");
  if (!states) throw std::runtime_error((out / "states.csv").string() + ": cannot be written");
  states << "t,sequence,finger,tip_x,tip_y,tip_z,contact_x,contact_y,contact_z,fx,fy,fz,sigma,"
            "validity";

  std::unique_ptr<ScriptedCamera> scripted;
  std::unique_ptr<FrameSource> recorded;
  std::optional<Eigen::Vector3d> p_S_tip_reported;
  if (scene.sense.camera->source == Camera::Source::kSimulated) {
    scripted = std::make_unique<ScriptedCamera>(scene);
    p_S_tip_reported = scene.manipulator.home;
  } else {
    recorded = OpenFrameSource(scene, false);
  }
  states << (scripted ? ",true_fx,true_fy,true_fz\n" : "\n");
  FrameSource& source = scripted ? static_cast<FrameSource&>(*scripted) : *recorded;

  std::optional<Frame> frame = source.Next(stop);
  if (!frame) throw std::runtime_error(source.description() + ": no picture came");
  Estimator estimator(scene, *frame, p_S_tip_reported);
  OfflineSummary summary;
  summary.has_truth = scripted != nullptr;
  summary.registration = estimator.registration();
  summary.model = estimator.touch().deformation->info();

  const Time start = frame->sensed_at;
  const auto began = std::chrono::steady_clock::now();
  std::vector<Compared> compared;
  while (frame) {
    const Felt& felt = estimator.Feel(*frame);
    states << Row(felt, start, scripted ? &scripted->truth() : nullptr) << std::flush;
    if (options.pictures) WritePicture(pictures, *frame, estimator, scene);
    ++summary.frames;
    ++summary.validity[std::string(ToString(felt.validity))];
    if (felt.validity == Validity::kTrackingLost) ++summary.tracking_lost;
    if (scripted) {
      const SiteTruth& truth = scripted->truth();
      const LocalModel& local = felt.local_model;
      compared.push_back({felt.force ? felt.force->norm() : std::nan(""),
                          (local.stiffness * local.normal * truth.depth).norm(),
                          truth.force.norm()});
    }
    if (options.progress) options.progress(summary.frames);
    const auto fetch = std::chrono::steady_clock::now();
    frame = source.Next(stop);
    summary.capture.Add(
        std::chrono::duration<double, std::micro>(std::chrono::steady_clock::now() - fetch)
            .count());
  }
  summary.seconds = std::chrono::duration<double>(std::chrono::steady_clock::now() - began).count();
  summary.times = estimator.times();
  double peak = 0;
  for (const Compared& c : compared) peak = std::fmax(peak, c.truth);
  for (const Compared& c : compared) {
    const bool contact = c.truth > kContactShare * peak || c.estimated > kContactShare * peak;
    if (contact && std::isfinite(c.estimated))
      summary.budget.Add(c.estimated, c.model_at_truth, c.truth);
  }
  WriteSummary(summary, scene, out / "summary.json");
  return summary;
}

}  // namespace palpate
