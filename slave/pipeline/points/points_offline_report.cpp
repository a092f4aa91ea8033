// Results of a run with tracked points: errors of positions and forces.
#include <cmath>
#include <limits>
#include <map>
#include <stdexcept>

#include <spdlog/fmt/fmt.h>

#include "shared/text/text.h"
#include "slave/capture/codecs/codecs.h"
#include "slave/capture/ground_truth.h"
#include "slave/pipeline/offline/offline_report.h"
#include "slave/pipeline/points/points_scores.h"
#include "slave/pipeline/points/points_sense.h"

namespace palpate {
namespace {

using Eigen::Isometry3d;
using Eigen::Vector3d;

nlohmann::ordered_json ErrorJson(const ErrorOfPoints& error) {
  if (error.count() == 0) return nullptr;
  return {{"rms_m", error.rms()}, {"peak_m", error.peak()}, {"count", error.count()}};
}

void AddErrorLine(const ErrorOfPoints& error, const char* what, std::vector<std::string>* lines) {
  if (error.count() == 0) return;
  lines->push_back(fmt::format("{}: rms {:.3f} mm, largest {:.3f} mm, over {} points", what,
                               1e3 * error.rms(), 1e3 * error.peak(), error.count()));
}

// Adds the results of the steps of paper C's figures 5 and 6.
void AddLines(const std::vector<PressStep>& steps, std::vector<std::string>* lines) {
  if (steps.empty()) return;
  lines->push_back(fmt::format("  {:>10} {:>12} {:>13} {:>12} {:>7} {:>21}", "depth [mm]",
                               "true [N]", "estimated [N]", "error [N]", "[%]",
                               "point error [mm]"));
  for (const PressStep& step : steps) {
    const double share = step.true_force > 0 ? 100 * step.force_error / step.true_force : 0;
    lines->push_back(fmt::format("  {:>10.2f} {:>12.4f} {:>13.4f} {:>12.4f} {:>7.1f} {:>21.3f}",
                                 1e3 * step.depth, step.true_force, step.force, step.force_error,
                                 share, 1e3 * step.displacement.peak()));
  }
}

// Compares the true values of each pair with the estimate.
class Comparison {
 public:
  Comparison(const GroundTruth& truth, const Isometry3d& X_SO) : truth_(truth), X_SO_(X_SO) {}

  void Add(PointsSense* sense, const Truth& truth, std::vector<ComparedForces>* compared) {
    const SurfaceObservation& seen = sense->observation();
    if (sense->estimator() == nullptr) return AddTarget(seen);
    if (!truth.solved) return;
    if (seen.found) AddDisplacements(seen);
    const std::optional<Vector3d>& force = sense->estimate().force;
    steps_.Add(truth.depth, truth.force.norm(),
               force ? std::optional(force->norm()) : std::nullopt);
    LoadIdentifier& body = sense->estimator()->body();
    Vector3d p_O, n_O;
    body.Nearest(X_SO_.inverse() * truth.p_S_tip, &p_O, &n_O);
    compared->push_back(
        {force.value_or(kUnknownVector), truth.force, body.PressAt(p_O, truth.depth).force});
  }
  void WriteErrors(nlohmann::ordered_json* json) const {
    (*json)["displacement_error"] = ErrorJson(displacement_);
    (*json)["place_error"] = ErrorJson(place_);
    (*json)["steps"] = ToJson(steps_.steps());
  }
  void AppendLines(std::vector<std::string>* lines) const {
    AddErrorLine(displacement_, "error of the points' displacements", lines);
    AddErrorLine(place_, "error of the points' positions since the first pair", lines);
    AddLines(steps_.steps(), lines);
  }

 private:
  void AddDisplacements(const SurfaceObservation& seen) {
    for (const SurfacePoint& point : seen.points) {
      if (!point.seen) continue;
      const Vector3d p_O = X_SO_.inverse() * point.p_S_rest;
      const Vector3d error =
          point.p_S - point.p_S_rest - X_SO_.linear() * truth_.TrueDisplacement(p_O.head<2>());
      displacement_.Add(error);
      steps_.Add(error);
    }
  }
  // Each point is assigned to the target's position when it was first seen.
  void AddTarget(const SurfaceObservation& seen) {
    const Isometry3d X_SB = truth_.target()->X_SB;
    X_SB_first_.resize(seen.points.size());
    for (std::size_t i = 0; i < seen.points.size(); ++i) {
      const SurfacePoint& point = seen.points[i];
      if (!seen.found || !point.seen) continue;
      if (!X_SB_first_[i]) X_SB_first_[i] = X_SB;
      place_.Add(point.p_S - X_SB * (X_SB_first_[i]->inverse() * point.p_S_rest));
    }
  }

  const GroundTruth& truth_;
  Isometry3d X_SO_;
  std::vector<std::optional<Isometry3d>> X_SB_first_;
  PressSteps steps_;
  ErrorOfPoints displacement_, place_;
};

// File of the tracked points, a row per visible point.
class PointsFile {
 public:
  explicit PointsFile(const std::filesystem::path& file) : file_(file), stream_(file) {
    stream_ << "t,sequence,point,x,y,z,sigma_x,sigma_y,sigma_z,rest_x,rest_y,rest_z,left_u,left_v,"
               "disparity_px,sigma_px,miss_px\n"
            << std::flush;
    RequireWritten(stream_.good(), file_);
  }
  void Write(double t, const SurfaceObservation& seen) {
    for (const SurfacePoint& point : seen.points) {
      if (!point.seen) continue;
      const Vector3d sigma = point.covariance.diagonal().cwiseMax(0).cwiseSqrt();
      stream_ << fmt::format("{:.6f},{},{}", t, seen.sequence, point.id);
      for (const Vector3d* v : {&point.p_S, &sigma, &point.p_S_rest}) {
        stream_ << fmt::format(",{:.9g},{:.9g},{:.9g}", v->x(), v->y(), v->z());
      }
      stream_ << (point.sigma_px > 0
                      ? fmt::format(",{:.4f},{:.4f},{:.4f},{:.4f},{:.4f}\n", point.left_I.x(),
                                    point.left_I.y(), point.left_I.x() - point.right_I.x(),
                                    point.sigma_px, point.miss_px)
                      : ",,,,,\n");
    }
    stream_ << std::flush;
    RequireWritten(stream_.good(), file_);
  }

 private:
  std::filesystem::path file_;
  std::ofstream stream_;
};

// One row per pair. The tool's place is empty where no manipulator moves it.
class PointsOfflineReport final : public OfflineReport {
 public:
  PointsOfflineReport(PointsSense* sense, const GroundTruth* truth) : sense_(*sense) {
    if (truth != nullptr) comparison_.emplace(*truth, sense->scene().object.X_SO);
  }

  std::vector<StateRow> Add(Time start, const Truth* truth) override {
    const SurfaceObservation& seen = sense_.observation();
    const ContactEstimate& estimate = sense_.estimate();
    const bool has_force_estimate = sense_.estimator() != nullptr;
    if (truth != nullptr) comparison_->Add(&sense_, *truth, &compared_);
    if (!sense_.why().empty()) ++reasons_[std::string(sense_.why())];
    tally_.Add(seen.points, !sense_.takes_rest());
    if (points_) points_->Write(SecondsBetween(start, estimate.sensed_at), seen);
    const bool knows_force = truth != nullptr && has_force_estimate && truth->solved;
    StateRow row = RowOf(estimate, start, knows_force ? std::optional(truth->force) : std::nullopt);
    if (truth == nullptr && has_force_estimate) row.p_S_tip = kUnknownVector;
    was_placed_ |= has_force_estimate ? estimate.force.has_value() : seen.found;
    if (!was_placed_) row.p_S_contact = kUnknownVector;
    return {row};
  }

  // Writes left and right images and the rig, which can be processed again.
  void OpenFrames(const std::filesystem::path& folder) override {
    std::filesystem::create_directories(folder / "left");
    if (!std::filesystem::is_empty(folder / "left")) {
      throw std::invalid_argument(
          fmt::format("--frames: {} contains images of another run: expected another --out, or "
                      "an empty folder",
                      (folder / "left").string()));
    }
    if (!sense_.scene().sense.Find<StereoCameras>()) return;
    std::filesystem::create_directories(folder / "right");
    WriteRig(folder / "rig.yaml", sense_.rig());
  }
  void WriteFrame(const std::filesystem::path& folder) const override {
    const StereoPair& pair = sense_.pair();
    const auto write = [&](const char* side, const cv::Mat& image) {
      if (image.empty()) return;
      WriteWholeFile(folder / side / fmt::format("{:06}.png", pair.sequence), EncodePng(image));
    };
    write("left", pair.left);
    write("right", pair.right);
  }

  void OpenPoints(const std::filesystem::path& file) override { points_.emplace(file); }

  void RequireComplete(std::uint64_t samples) const override {
    const SurfacePointTracker& tracker = sense_.tracker();
    if (tracker.at_rest_known()) return;
    const std::string source = sense_.info().source;
    throw std::runtime_error(
        samples < static_cast<std::uint64_t>(tracker.rest_images())
            ? fmt::format(
                  "{}: {} are fewer than the {} of the rest shape: no force can be estimated",
                  source, samples, tracker.rest_images())
            : fmt::format("{}: {}; it was not complete in any of these {}: {}", source,
                          RestInWords(tracker), samples, WhyNotFound(sense_.scene())));
  }

  void Finish(OfflineSummary* summary) const override {
    const std::size_t points = tally_.points(), followed = tally_.followed();
    nlohmann::ordered_json& own = summary->own;
    own["reasons"] = reasons_;
    own["points"] = {{"count", points}, {"followed", followed}, {"unseen", tally_.missed()}};
    own["displacement_error"] = nullptr;
    own["place_error"] = nullptr;
    own["steps"] = nlohmann::ordered_json::array();
    if (comparison_) comparison_->WriteErrors(&own);
    for (const auto& [why, count] : reasons_) {
      summary->lines.push_back(fmt::format("  {} times: {}", count, why));
    }
    summary->lines.push_back(fmt::format(
        "{} of {} points tracked, {} never detected; a tracked point was missed {} times", followed,
        points, points - followed, tally_.missed()));
    if (comparison_) comparison_->AppendLines(&summary->lines);
  }

 private:
  PointsSense& sense_;
  std::optional<Comparison> comparison_;          // set if the truth is known
  std::optional<PointsFile> points_;              // set if it was requested
  std::map<std::string, std::uint64_t> reasons_;  // why pairs are not `valid`
  TrackingCounts tally_;
  bool was_placed_ = false;  // whether a contact was located at least once
};

}  // namespace

std::unique_ptr<OfflineReport> PointsSense::OpenOfflineReport(const GroundTruth* truth) {
  return std::make_unique<PointsOfflineReport>(this, truth);
}

}  // namespace palpate
