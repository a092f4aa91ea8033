#include <algorithm>
#include <chrono>
#include <memory>
#include <numbers>
#include <stop_token>
#include <string>
#include <variant>

#include <spdlog/fmt/fmt.h>

#include "shared/state/driven_clock.h"
#include "shared/telemetry/latency_histogram.h"
#include "slave/capture/frame_source.h"
#include "slave/capture/simulated_samples.h"
#include "slave/commands/check/check.h"
#include "slave/commands/check/stereo_expectation.h"
#include "slave/mechanics/factory/choose_model.h"
#include "slave/mechanics/factory/make_model.h"
#include "slave/pipeline/load/plate_limits.h"
#include "slave/pipeline/points/points_sense.h"
#include "slave/pipeline/points/surface_point_tracker.h"
#include "slave/pipeline/press/membrane_body.h"
#include "slave/vision/dots/dot_layout.h"
#include "slave/vision/texture/epipolar_line.h"

namespace palpate {
namespace {

constexpr double kDegrees = 180 / std::numbers::pi;  // [deg/rad]

std::string Size(const std::array<int, 2>& size) {
  return fmt::format("{} x {} px", size[0], size[1]);
}

void PrintDome(const Scene& scene, const DomeGeometry& dome) {
  PrintObject(scene);
  PrintLine("model", ChooseModel(scene).model.kind + ": " + ChooseModel(scene).reason);
  const auto body = MakeMembraneBody(scene);
  const ModelInfo& info = body->info();
  PrintLine("precompute", fmt::format("{:.3g} ms, {:.3g} MB of memory, {} degrees of freedom",
                                      1e3 * info.precompute_s,
                                      static_cast<double>(info.memory_bytes) * 1e-6, info.dof));
  const double depth = scene.tool->width / 4;
  const auto press = body->PressAt({0, 0, dome.inflation}, depth);
  PrintLine("contact", fmt::format("an indentation of {} at the top needs {:.3g} N",
                                   LengthInWords(depth), press.force));
}

void PrintModelOf(const Scene& scene) {
  const auto* dome = std::get_if<DomeGeometry>(&scene.object.geometry);
  if (dome != nullptr && EstimatesForce(scene)) return PrintDome(scene, *dome);
  if (EstimatesForce(scene)) {
    PrintBody(scene);
    return;
  }
  PrintObject(scene);
  PrintLine(
      "model",
      "none: the object has no fixed boundary, so its points are tracked and the force is unknown");
}

void PrintSight(const Scene& scene, const StereoRig& rig) {
  const auto sight = ExpectedSight(scene, rig);
  if (!sight) {
    PrintLine("accuracy", IsHeld(scene.object)
                              ? "NOTHING: the object origin is not in front of both cameras; check "
                                "sense.camera.pose, the pose of the left camera"
                              : "unknown: the scene has no pose of the left camera, so points are "
                                "reported in its own frame");
    return;
  }
  PrintLine("accuracy",
            fmt::format("{} from the object origin: with {:g} px in the image a point has a sigma "
                        "of {} along the line of sight and {} across it",
                        LengthInWords(sight->distance), scene.sense.Find<PointTracking>()->sigma,
                        LengthInWords(sight->sigma_depth), LengthInWords(sight->sigma_across)));
}

const char* PairInWords(const StereoCameras& pair) {
  using Source = StereoCameras::Source;
  if (pair.source == Source::kSimulated) return "simulated pair";
  if (pair.source == Source::kFiles) return "pair of image files";
  return pair.source == Source::kCameras ? "live pair" : "pair from a driver";
}

void PrintRig(const Scene& scene, const StereoRig& rig) {
  PrintLine(
      "cameras",
      fmt::format("{}, {}, focal length {:.4g} px, {} apart{}",
                  PairInWords(*scene.sense.Find<StereoCameras>()), Size(rig.left.size), rig.left.fx,
                  LengthInWords(rig.baseline()),
                  rig.rms_px > 0 ? fmt::format("; calibration residual {:.3g} px rms", rig.rms_px)
                                 : std::string()));
  PrintSight(scene, rig);
}

void PrintForce(const Scene& scene, const StereoRig& rig,
                const std::vector<Eigen::Vector2d>& places_O) {
  const auto expected = ExpectedForce(scene, rig, places_O);
  if (!expected) return;
  if (expected->validity == Validity::kFailed) {
    PrintLine("force",
              "NOT DETERMINED by these dots for this contact: use a larger depth, or dots with a "
              "smaller sigma");
    return;
  }
  PrintLine("force",
            fmt::format("{:.4g} N for an indentation of {} below home{}; the sigma of the dots "
                        "alone contributes {:.3g} N ({:.2g} %)",
                        expected->force, LengthInWords(scene.operator_options.press_depth),
                        expected->validity == Validity::kValid ? "" : ", beyond the model's range",
                        expected->sigma, 100 * expected->sigma / expected->force));
}

void PrintDots(const Scene& scene, const StereoRig& rig) {
  const auto places_O = DotPlaces(*scene.sense.Find<PointTracking>());
  const auto seen_O = InBothImages(scene, rig, places_O);
  PrintLine(
      "dots",
      fmt::format("{} of {} with radius {} are visible to both cameras at rest{}", seen_O.size(),
                  places_O.size(), LengthInWords(scene.sense.Find<PointTracking>()->dot_radius),
                  seen_O.size() == places_O.size() ? "" : ": use a wider view or a smaller array"));
  if (EstimatesForce(scene)) PrintForce(scene, rig, seen_O);
}

std::string FittedTo(const Scene& scene) {
  const bool is_plate = std::holds_alternative<MembraneGeometry>(scene.object.geometry);
  if (!EstimatesForce(scene) || !is_plate) return {};
  return fmt::format(
      "; the force is fitted to at most {0} points on the membrane, spread evenly, to keep up with "
      "the image rate",
      PlateLimits::kMaxPoints);
}

std::string RangeInWords(const StereoRig& rig) {
  const auto nearest = NearestInBoth(rig);
  if (!nearest)
    return "NO point on the left camera's axis is visible in the right image: check the rig file";
  return fmt::format("points nearer than {} are not visible to both cameras",
                     LengthInWords(*nearest));
}

void PrintPoints(const Scene& scene, const StereoRig& rig) {
  const PointTracking& points = *scene.sense.Find<PointTracking>();
  switch (points.track) {
    case PointTracking::Track::kDots:
      PrintDots(scene, rig);
      break;
    case PointTracking::Track::kTexture:
      PrintLine("texture",
                fmt::format("{} of {} px, chosen in the first left image; {}",
                            points.at.empty() ? fmt::format("up to {} windows", points.count)
                                              : fmt::format("{} windows", points.at.size()),
                            points.window, RangeInWords(rig)));
      break;
    case PointTracking::Track::kSurface:
      PrintLine("surface", "tracked in cells of the depth images" + FittedTo(scene));
      break;
  }
}

// Findings of the tracker in the first images.
struct FirstLook {
  int images = 0;
  int until_rest = 0;                // number of images until the baseline was known; 0: it was not
  std::size_t points = 0, seen = 0;  // in the last one
  double us = 0;            // per image [us], without the first one, which allocates memory
  LatencyHistogram checks;  // part of it for the checks
};

FirstLook FirstSample(const Scene& scene, const StereoRig& rig, StereoSource& source,
                      SurfacePointTracker& tracker) {
  constexpr int kImages = 15;
  FirstLook look;
  std::chrono::duration<double, std::micro> spent(0);
  while (look.images < kImages) {
    const auto pair = source.Next(std::stop_token());
    if (!pair) break;
    if (look.images++ == 0) RequireRigFits(scene, rig, *pair);
    const auto began = std::chrono::steady_clock::now();
    const SurfaceObservation& observation = tracker.Process(*pair);
    if (look.images > 1) spent += std::chrono::steady_clock::now() - began;
    if (look.images > 1) look.checks.Add(tracker.checks_us());
    if (look.until_rest == 0 && tracker.at_rest_known()) look.until_rest = look.images;
    look.points = observation.points.size();
    look.seen = static_cast<std::size_t>(
        std::ranges::count_if(observation.points, [](const SurfacePoint& p) { return p.seen; }));
  }
  look.us = look.images > 1 ? spent.count() / (look.images - 1) : 0;
  return look;
}

std::string SeenInWords(const Scene& scene, const SurfacePointTracker& tracker,
                        const FirstLook& look) {
  if (look.until_rest == 0) {
    const bool are_enough = look.images >= tracker.rest_images();
    return fmt::format("NOTHING yet: {}; the first {} do not{}{}", RestInWords(tracker),
                       look.images, are_enough ? ": " : "", are_enough ? WhyNotFound(scene) : "");
  }
  std::string words = fmt::format(
      "{} of {} points in the last of {} images; the rest shape comes from the first {}: nothing "
      "may touch the object in them",
      look.seen, look.points, look.images, look.until_rest);
  const bool is_texture =
      scene.sense.Find<PointTracking>() &&
      scene.sense.Find<PointTracking>()->track == PointTracking::Track::kTexture;
  if (is_texture && 2 * look.seen < look.points) {
    words +=
        fmt::format(". FEW are in both images: {}; or the images change too fast", WhyFewWindows());
  }
  return words;
}

// Compares the surface at rest with the scene's body.
void PrintRest(const RestSurface& rest) {
  if (rest.meets && rest.distance > 0) {
    std::string words = fmt::format(
        "{:.4g} +- {:.2g} mm from the camera, where the scene has the body at {:.4g} mm; tilted by "
        "{:.2g} +- {:.2g} deg",
        1e3 * (rest.distance + rest.off), 2e3 * rest.sigma_off, 1e3 * rest.distance,
        rest.tilt * kDegrees, 2 * rest.sigma_tilt * kDegrees);
    if (rest.edge < 1) words += fmt::format("; {:.0f} % of its edge are seen", 100 * rest.edge);
    PrintLine("at rest", words);
  }
  if (!rest.fault.empty()) PrintLine("", "EXTRAPOLATED: " + std::string(rest.fault));
}

void PrintFirstLook(const Scene& scene, const StereoRig& rig) {
  if (TakesImages(scene.sense)) {
    PrintLine("images", "none until a driver sends them (FeedImages)");
    return;
  }
  const DrivenClock clock;
  const auto simulation = IsSimulated(scene) ? StartSimulation(scene, {}) : nullptr;
  const auto source = simulation ? simulation->OpenPairs() : OpenStereo(scene);
  const auto tracker = MakeSurfacePointTracker(scene, rig);
  PrintLine("images", source->description());
  const FirstLook look = FirstSample(scene, rig, *source, *tracker);
  PrintLine("detected", SeenInWords(scene, *tracker, look));
  if (tracker->rest()) PrintRest(*tracker->rest());
  if (look.images < 2) return;
  const double rate = SensorRate(scene.sense);
  PrintLine("rate",
            fmt::format("{:.3g} us per image to find the points: {} the {:g} Hz of the images",
                        look.us, look.us * 1e-6 * rate < 1 ? "meets" : "MISSES", rate));
  const double checks_us = look.checks.Quantile(0.99);
  PrintLine("", fmt::format("their checks take {:.3g} us (p99), {:.2g} % of the image period",
                            checks_us, 100e-6 * checks_us * rate));
}

void PrintDepthCamera(const DepthImages& depth, const Scene& scene) {
  const Eigen::Vector3d p_D = depth.X_SD.inverse() * scene.object.X_SO.translation();
  PrintLine("depth", fmt::format("counts of {}, focal length {:.4g} px, {} from the object origin; "
                                 "sigma of one depth {}; depths beyond {} are not used",
                                 LengthInWords(depth.unit), depth.fx, LengthInWords(p_D.norm()),
                                 LengthInWords(depth.sigma), LengthInWords(MaxDepth(scene))));
}

}  // namespace

void CheckStereo(const Scene& scene) {
  PrintModelOf(scene);
  const StereoRig rig = RigOf(scene);
  PrintCameras(scene);  // before they are opened, because one may be missing
  if (EstimatesForce(scene)) PrintManipulator(scene);
  if (scene.sense.Find<StereoCameras>()) PrintRig(scene, rig);
  if (scene.sense.Find<DepthImages>()) PrintDepthCamera(*scene.sense.Find<DepthImages>(), scene);
  PrintPoints(scene, rig);
  PrintFirstLook(scene, rig);
  PrintChecks(scene.sense.Find<StereoCameras>() ? "of a stereo pair" : "of a depth camera");
  if (EstimatesForce(scene)) PrintHand(scene);
  PrintLine("off", "fingertips and tip tracking: only the object's points are used");
  PrintLine("on demand", "the deformed shape and the images: sent only while a client watches");
}

}  // namespace palpate
