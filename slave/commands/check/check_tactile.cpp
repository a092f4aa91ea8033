#include <array>
#include <numbers>
#include <string>
#include <string_view>

#include <spdlog/fmt/fmt.h>

#include "slave/commands/check/check.h"
#include "slave/pipeline/fingertips/tactile_estimator.h"

namespace palpate {
namespace {

constexpr double kMilli = 1e-3;

std::string Source(const Tactile& tactile) {
  switch (tactile.source) {
    case Tactile::Source::kSimulated:
      return "simulated fingertips";
    case Tactile::Source::kStream:
      return "a stream from a driver (FeedTactile)";
    case Tactile::Source::kRecording:
      break;
  }
  return "recording " + tactile.file.string();
}

std::string_view MotionInWords(const Finger& finger) {
  constexpr std::array<std::string_view, 3> kWords{
      "moves with the manipulator", "moves opposite to the manipulator", "stationary"};
  return kWords[static_cast<std::size_t>(finger.motion)];
}

void PrintFingers(const Scene& scene) {
  const Tactile& tactile = *scene.sense.Find<Tactile>();
  for (const Finger& finger : tactile.fingers) {
    const Eigen::Vector3d& p = finger.X_SF.translation();
    std::string where =
        fmt::format("{} at home at ({}, {}, {}), {}", finger.name, LengthInWords(p.x()),
                    LengthInWords(p.y()), LengthInWords(p.z()), MotionInWords(finger));
    if (tactile.has_recorded_poses) where = finger.name + ", its poses from the recording";
    if (!MeetsObject(scene)) where = finger.name + ", no pose: only its force is reported";
    PrintLine("fingertip", where);
  }
  if (!tactile.channels.are_electrodes()) {
    PrintLine("channels", fmt::format("{} in {}", tactile.channels.count, tactile.channels.unit));
  }
  PrintLine("samples",
            fmt::format("{}, {:g} Hz; baseline from the first {}, without contact ({:.3g} s)",
                        Source(tactile), tactile.rate, tactile.rest_samples,
                        tactile.rest_samples / tactile.rate));
}

void PrintNetwork(const ForceNetwork* network) {
  if (network == nullptr) {
    PrintLine("network", "none: the force is unknown and the object is not deformed");
    return;
  }
  const NetworkInfo& info = network->info();
  PrintLine("network", fmt::format("{}, window of {} samples{}", info.architecture, info.window,
                                   info.origin.empty() ? "" : "; " + info.origin));
  PrintLine("range",
            info.learnt_force > 0
                ? fmt::format("trained up to {:.3g} N; `extrapolated` beyond", info.learnt_force)
                : "unknown: no force is flagged as out of range");
  PrintLine(
      "error",
      info.sigma.norm() > 0
          ? fmt::format("rms {:.3g}, {:.3g}, {:.3g} mN on contacts not used for training",
                        info.sigma.x() / kMilli, info.sigma.y() / kMilli, info.sigma.z() / kMilli)
          : "unknown for this network; the values of paper B, table I, are used");
}

void PrintChecksWith(const ForceNetwork* network) {
  if (network == nullptr) return;
  if (network->info().pattern.known()) return PrintChecks("of fingertips");
  PrintLine("checks", "off: the network file has no model of how its signals correlate");
}

std::string LayoutInWords(const Tactile& tactile) {
  const bool are_electrodes = tactile.channels.are_electrodes();
  if (!tactile.electrodes.empty()) {
    return (are_electrodes ? "electrodes from " : "channels from ") + tactile.electrodes.string();
  }
  return are_electrodes ? "electrodes of the simulated fingertip" : "no layout of the channels";
}

void PrintPlaces(const Scene& scene, const Localiser& localiser) {
  const Tactile& tactile = *scene.sense.Find<Tactile>();
  PrintLine("localiser", fmt::format("{}; {}", localiser.name(), LayoutInWords(tactile)));
  if (!MeetsObject(scene)) return;
  PrintLine("poses", fmt::format("sigma {:.2g} deg about each axis: {:.1f} % of a force",
                                 tactile.pose_tolerance * 180 / std::numbers::pi,
                                 100 * std::numbers::sqrt2 * tactile.pose_tolerance));
  PrintLine("contact",
            fmt::format("within {} of the surface, {}, prescribed {}", LengthInWords(tactile.gate),
                        tactile.patch > 0 ? LengthInWords(tactile.patch) + " wide"
                                          : std::string("at one point"),
                        tactile.hold == Tactile::Hold::kForce ? "force" : "displacement"));
}

// Returns samples of fingertips with changing counts that touch nothing.
TactileFrame Busy(const Scene& scene, int sample) {
  TactileFrame frame;
  frame.sequence = static_cast<std::uint64_t>(sample) + 1;
  for (std::size_t i = 0; i < scene.sense.Find<Tactile>()->fingers.size(); ++i) {
    FingerReading& reading = frame.fingers[i];
    reading.present = true;
    const bool rests = sample < scene.sense.Find<Tactile>()->rest_samples;
    reading.channels.resize(static_cast<std::size_t>(scene.sense.Find<Tactile>()->channels.count));
    reading.channels.fill(rests ? 3000.0F : 3010.0F + static_cast<float>(sample % 7));
    reading.pac = reading.pdc = 2000;
  }
  return frame;
}

void PrintPace(const Scene& scene, TactileEstimator& estimator) {
  constexpr int kSamples = 300;
  const int rest = scene.sense.Find<Tactile>()->rest_samples;
  for (int i = 0; i < rest + kSamples; ++i) {
    estimator.Estimate(Busy(scene, i), scene.manipulator.home);
  }
  const double us = estimator.times().tactile.Quantile(0.5);
  const double rate = scene.sense.Find<Tactile>()->rate;
  PrintLine("rate", fmt::format("{:.3g} us per sample for force and contact point of {} "
                                "fingertip(s): {} the {:g} Hz of the samples",
                                us, estimator.finger_count(),
                                us * 1e-6 * rate < 1 ? "meets" : "MISSES", rate));
  const double checks_us = estimator.times().checks.Quantile(0.99);
  PrintLine("", fmt::format("its checks take {:.3g} us (p99), {:.2g} % of the sample period",
                            checks_us, 100e-6 * checks_us * rate));
}

void PrintLocalModel(const Scene& scene, TactileEstimator& estimator) {
  const LocalModel& local = estimator.estimate().local_model;
  if (!local.known()) return;
  const double stiffness = local.normal.dot(local.stiffness * local.normal);
  const double depth = scene.operator_options.press_depth;
  const Eigen::Vector3d& n = local.normal;
  PrintLine(
      "local model",
      fmt::format("{:.3g} N/m against ({:.2g}, {:.2g}, {:.2g}) before the first contact, {:.3g} N "
                  "for an indentation of {}, from {} away; the estimated force corrects it",
                  stiffness, -n.x(), -n.y(), -n.z(), stiffness * depth, LengthInWords(depth),
                  LengthInWords(-local.Penetration(scene.manipulator.home))));
}

}  // namespace

void CheckTactile(const Scene& scene) {
  if (MeetsObject(scene)) {
    PrintBody(InStepWithSamples(scene));
  } else {
    PrintObject(scene);
    PrintLine("model",
              "none: the scene has no poses of the fingertips, so the object is not deformed");
  }
  TactileEstimator estimator(scene);
  PrintFingers(scene);
  PrintNetwork(estimator.network());
  PrintChecksWith(estimator.network());
  PrintPlaces(scene, estimator.localiser());
  PrintPace(scene, estimator);
  PrintLocalModel(scene, estimator);
  if (MeetsObject(scene)) PrintManipulator(scene);
  PrintHand(scene);
  PrintLine("off", "cameras: only the fingertips are used");
  PrintLine("on demand", "the deformed shape: sent only while a client watches");
}

}  // namespace palpate
