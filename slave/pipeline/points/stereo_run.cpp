#include "slave/pipeline/points/stereo_run.h"

#include <chrono>
#include <cmath>
#include <fstream>
#include <limits>
#include <memory>
#include <optional>
#include <stdexcept>
#include <utility>
#include <variant>

#include <nlohmann/json.hpp>
#include <spdlog/fmt/fmt.h>

#include "slave/capture/codecs/codecs.h"
#include "slave/capture/picture_files.h"
#include "slave/pipeline/offline/states_file.h"
#include "slave/pipeline/points/points_overlay.h"
#include "slave/pipeline/points/surface_point_tracker.h"
#include "slave/pipeline/points/surface_teller.h"
#include "slave/pipeline/points/tracking_counts.h"
#include "slave/pipeline/stopwatch.h"
#include "slave/site/points/scripted_membrane.h"

namespace palpate {
namespace {

using Eigen::Isometry3d;
using Eigen::Vector3d;

const Vector3d kNowhere = Vector3d::Constant(std::numeric_limits<double>::quiet_NaN());

// Where the pairs come from, and the site that knows the truth.
struct Origin {
  Origin(const Scene& scene, double duration) {
    const bool is_simulated =
        scene.sense.stereo && scene.sense.stereo->source == StereoCameras::Source::kSimulated;
    const bool goes_on =
        is_simulated && !std::holds_alternative<MembraneGeometry>(scene.object.geometry);
    if (duration > 0 && !goes_on) {
      throw std::invalid_argument(
          fmt::format("--duration: accepted for a simulated target that goes on; {} of {} end by "
                      "themselves",
                      is_simulated ? "the scripted presses" : "the files", scene.file.string()));
    }
    if (is_simulated) {
      MembraneScript script;
      if (duration > 0) script.target_seconds = duration;
      auto scripted = std::make_unique<ScriptedMembrane>(scene, script);
      site = &scripted->site();
      source = std::move(scripted);
    } else {
      source = OpenStereoFiles(scene, false);
    }
  }
  std::unique_ptr<StereoSource> source;
  const StereoSite* site = nullptr;  // null: real
};

// What the site knows of each pair, beside what was told.
class Comparison {
 public:
  Comparison(const Scene& scene, const StereoSite& site) : site_(site), X_SO_(scene.object.X_SO) {}

  void Add(const SurfaceObservation& seen, SurfaceTeller* teller) {
    if (teller->estimator() == nullptr) {
      AddTarget(seen);
      return;
    }
    const MembraneTruth truth = site_.truth();
    if (!truth.solved) return;
    if (seen.found) AddDisplacements(seen);
    const std::optional<Vector3d>& force = teller->felt().force;
    steps_.Add(truth.depth, truth.force.norm(),
               force ? std::optional(force->norm()) : std::nullopt);
    SurfaceEstimator& estimator = *teller->estimator();
    const Vector3d p_O_tip = estimator.X_SO().inverse() * truth.p_S_tip;
    Vector3d p_O, n_O;
    estimator.body().Nearest(p_O_tip, &p_O, &n_O);
    compared_.push_back({force ? force->norm() : std::nan(""),
                         estimator.body().PressAt(p_O, truth.depth).force, truth.force.norm()});
  }
  void Write(StereoSummary* summary) const {
    summary->budget = BudgetOf(compared_);
    summary->steps = steps_.steps();
    summary->displacement = displacement_;
    summary->place = place_;
  }

 private:
  void AddDisplacements(const SurfaceObservation& seen) {
    for (const SurfacePoint& point : seen.points) {
      if (!point.seen) continue;
      const Vector3d p_O = X_SO_.inverse() * point.p_S_rest;
      const Vector3d error =
          point.p_S - point.p_S_rest - X_SO_.linear() * site_.TrueDisplacement(p_O.head<2>());
      displacement_.Add(error);
      steps_.Add(error);
    }
  }
  // Each point belongs to the target's place when it was first seen.
  void AddTarget(const SurfaceObservation& seen) {
    const Isometry3d X_SB = site_.target()->X_SB;
    X_SB_first_.resize(seen.points.size());
    for (std::size_t i = 0; i < seen.points.size(); ++i) {
      const SurfacePoint& point = seen.points[i];
      if (!seen.found || !point.seen) continue;
      if (!X_SB_first_[i]) X_SB_first_[i] = X_SB;
      place_.Add(point.p_S - X_SB * (X_SB_first_[i]->inverse() * point.p_S_rest));
    }
  }

  const StereoSite& site_;
  Isometry3d X_SO_;
  std::vector<std::optional<Isometry3d>> X_SB_first_;
  std::vector<ComparedForces> compared_;
  PressSteps steps_;
  ErrorOfPoints displacement_, place_;
};

nlohmann::ordered_json ErrorJson(const ErrorOfPoints& error) {
  if (error.count() == 0) return nullptr;
  return {{"rms_m", error.rms()}, {"peak_m", error.peak()}, {"count", error.count()}};
}

void WriteSummary(const StereoSummary& s, const Scene& scene, const std::filesystem::path& file) {
  const bool compares_forces = s.has_truth && s.tells_force;
  nlohmann::ordered_json json =
      SummaryJson(s, scene.name, {{s.eyes, s.look}, {"mechanics", s.mechanics}, {"total", s.total}},
                  compares_forces ? ToJson(s.budget) : nullptr);
  json["reasons"] = s.reasons;
  json["points"] = {
      {"count", s.points}, {"followed", s.points_followed}, {"unseen", s.points_unseen}};
  json["displacement_error"] = ErrorJson(s.displacement);
  json["place_error"] = ErrorJson(s.place);
  json["steps"] = ToJson(s.steps);
  WriteJson(json, file);
}

void WriteJpeg(const std::string& jpeg, const std::filesystem::path& file) {
  RequireWritten((std::ofstream(file, std::ios::binary) << jpeg << std::flush).good(), file);
}

class Run {
 public:
  Run(const Scene& scene, const StereoRunOptions& options)
      : scene_(scene),
        options_(options),
        origin_(scene, options.duration),
        rig_(RigOf(scene)),
        eyes_(MakeSurfacePointTracker(scene, rig_)),
        teller_(scene),
        states_(options.out, origin_.site != nullptr && EstimatesForce(scene)) {
    if (origin_.site != nullptr) comparison_.emplace(scene, *origin_.site);
    if (options.pictures) std::filesystem::create_directories(options.out / "pictures");
    if (options.frames) MakeFramesFolder();
    summary_.has_truth = origin_.site != nullptr;
    summary_.eyes = eyes_->stage();
    summary_.tells_force = EstimatesForce(scene);
    summary_.model = teller_.info();
  }

  StereoSummary Go(const std::stop_token& stop) {
    Stopwatch whole;
    while (const std::optional<StereoPair> pair = Fetch(stop)) {
      if (summary_.frames == 0) {
        RequireRigFits(scene_, rig_, *pair);
        start_ = pair->sensed_at;
      }
      Feel(*pair);
      if (options_.progress) options_.progress(summary_.frames);
    }
    if (summary_.frames == 0 && !stop.stop_requested()) {
      throw std::runtime_error(origin_.source->description() + ": no pictures came");
    }
    if (!eyes_->at_rest_known() && !stop.stop_requested()) RefuseRest();
    summary_.seconds = 1e-6 * whole.Lap();
    summary_.points = tally_.points();
    summary_.points_followed = tally_.followed();
    summary_.points_unseen = tally_.missed();
    summary_.mechanics = teller_.mechanics();
    if (comparison_) comparison_->Write(&summary_);
    WriteSummary(summary_, scene_, options_.out / "summary.json");
    return summary_;
  }

 private:
  void MakeFramesFolder() {
    const auto folder = options_.out / "frames";
    std::filesystem::create_directories(folder / "left");
    if (!std::filesystem::is_empty(folder / "left")) {
      throw std::invalid_argument(fmt::format(
          "--frames: {} holds pictures of another run, which would mix with these: accepted is "
          "another --out, or that folder emptied",
          (folder / "left").string()));
    }
    if (!scene_.sense.stereo) return;
    std::filesystem::create_directories(folder / "right");
    WriteRig(folder / "rig.yaml", rig_);
  }

  [[noreturn]] void RefuseRest() const {
    const auto needed = static_cast<std::uint64_t>(eyes_->rest_pictures());
    const std::string source = origin_.source->description();
    throw std::runtime_error(
        summary_.frames < needed
            ? fmt::format("{}: {} are fewer than the {} of the rest frame: nothing can be said",
                          source, summary_.frames, needed)
            : fmt::format("{}: {}, and was never complete in these {}: {}", source,
                          RestInWords(*eyes_), summary_.frames, WhyNotFound(scene_)));
  }

  std::optional<StereoPair> Fetch(const std::stop_token& stop) {
    Stopwatch lap;
    std::optional<StereoPair> pair = origin_.source->Next(stop);
    summary_.capture.Add(lap.Lap());
    return pair;
  }

  void Feel(const StereoPair& pair) {
    const Vector3d p_S_tip =
        origin_.site != nullptr ? origin_.site->truth().p_S_tip : scene_.manipulator.home;
    Stopwatch lap, total;
    const bool rest_known = eyes_->at_rest_known();
    const SurfaceObservation& seen = eyes_->Look(pair);
    summary_.look.Add(lap.Lap());
    const ContactEstimate& felt = teller_.Feel(seen, rest_known || seen.found, p_S_tip);
    summary_.total.Add(total.Lap());
    if (comparison_) comparison_->Add(seen, &teller_);
    Count(felt);
    tally_.Add(seen.points, !teller_.takes_rest());
    WriteRow(seen, felt);
    if (options_.frames) WriteFrames(pair);
    if (options_.pictures) WritePicture(pair, seen, felt);
  }

  void Count(const ContactEstimate& felt) {
    ++summary_.frames;
    summary_.Count(felt.validity);
    if (!teller_.why().empty()) ++summary_.reasons[std::string(teller_.why())];
  }

  void WriteRow(const SurfaceObservation& seen, const ContactEstimate& felt) {
    std::optional<Vector3d> true_force;
    if (summary_.has_truth && summary_.tells_force) {
      const MembraneTruth truth = origin_.site->truth();
      if (truth.solved) true_force = truth.force;
    }
    StateRow row = RowOf(felt, start_, true_force);
    if (!summary_.has_truth && summary_.tells_force) row.p_S_tip = kNowhere;
    was_placed_ |= summary_.tells_force ? felt.force.has_value() : seen.found;
    if (!was_placed_) row.p_S_contact = kNowhere;
    states_.Write(row);
  }

  void WriteFrames(const StereoPair& pair) {
    const auto write = [&](const char* side, const cv::Mat& picture) {
      if (picture.empty()) return;
      const auto file = options_.out / "frames" / side / fmt::format("{:06}.png", pair.sequence);
      RequireWritten(WritePng(picture, file), file);
    };
    write("left", pair.left);
    write("right", pair.right);
  }

  void WritePicture(const StereoPair& pair, const SurfaceObservation& seen,
                    const ContactEstimate& felt) {
    const OperatorOptions& hand = scene_.operator_options;
    const PointsOverlay overlay = MakePointsOverlay(
        *eyes_, seen, felt, hand.force_limit / hand.transform.force_scale, pair.left.rows);
    WriteJpeg(EncodeJpeg(DrawPoints(pair.left, overlay), 90),
              options_.out / "pictures" / fmt::format("{:06}.jpg", pair.sequence));
  }

  const Scene& scene_;
  const StereoRunOptions& options_;
  Origin origin_;
  StereoRig rig_;
  std::unique_ptr<SurfacePointTracker> eyes_;
  SurfaceTeller teller_;
  StatesFile states_;
  std::optional<Comparison> comparison_;  // where the site knows the truth
  StereoSummary summary_;
  TrackingCounts tally_;
  bool was_placed_ = false;  // the contact, once
  Time start_{};
};

}  // namespace

StereoSummary RunStereo(const Scene& scene, const StereoRunOptions& options,
                        const std::stop_token& stop) {
  return Run(scene, options).Go(stop);
}

}  // namespace palpate
