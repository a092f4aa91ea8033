#include "slave/commands/study/end_to_end.h"

#include <algorithm>
#include <cmath>
#include <memory>
#include <stdexcept>

#include <Eigen/Geometry>
#include <spdlog/fmt/fmt.h>

#include "slave/capture/simulated_samples.h"
#include "slave/mechanics/object_mesh.h"
#include "slave/pipeline/base/sensing_pipeline.h"
#include "slave/pipeline/offline/offline_report.h"
#include "slave/scene/scene_loader.h"
#include "slave/study/press_spec.h"

namespace palpate {
namespace {

constexpr double kTick = 1e-3;          // [s]
constexpr double kContactShare = 0.01;  // of the true peak

struct Sample {
  double t = 0;  // [s]
  Eigen::Vector3d p_S_tip{0, 0, 0};
  LocalModel local;
  double truth = 0, estimated = 0, model = 0, vision = 0;  // forces [N]; of `vision` the error
};

// The scene with further overrides and the same model, also where `auto` chose it.
Scene Changed(const Scene& scene, const std::vector<std::string>& overrides) {
  std::vector<std::string> all = scene.overrides;
  all.insert(all.end(), overrides.begin(), overrides.end());
  Scene changed = LoadScene(scene.file, all);
  changed.model = scene.model;
  return changed;
}

// What the master would show of `local` at a place.
double Rendered(const LocalModel& local, const Eigen::Vector3d& p_S) {
  const Eigen::Vector3d f = local.force + local.stiffness * (local.reference - p_S);
  return local.known() && local.Penetration(p_S) > 0 ? f.norm() : 0;
}

std::vector<Sample> RunPress(const Scene& scene, const std::stop_token& stop) {
  if (!IsSimulated(scene)) {
    throw std::invalid_argument(scene.file.string() +
                                ": --end-to-end: expected a scene with a simulated source, "
                                "because only it knows the true force");
  }
  const std::unique_ptr<Simulation> simulation = StartSimulation(scene, {});
  const std::unique_ptr<SensingPipeline> sense =
      MakeSensingPipeline(scene, {.is_live = false, .player = simulation.get()});
  const std::unique_ptr<OfflineReport> offline_report = sense->OpenOfflineReport(simulation.get());
  const bool of_depth = scene.sense.Find<Camera>() != nullptr;
  std::vector<Sample> samples;
  Time start{};
  while (!stop.stop_requested() && sense->Acquire(stop)) {
    const Truth truth = simulation->truth();
    sense->Process();
    const ContactEstimate estimate = sense->Estimate(SimulatedEncoders(scene, truth.p_S_tip));
    if (samples.empty()) start = estimate.sensed_at;
    offline_report->Add(start, &truth);
    Sample sample{SecondsBetween(start, estimate.sensed_at), truth.p_S_tip,
                  sense->LocalModelAt(estimate.p_S_tip)};
    sample.truth = truth.force.norm();
    sample.estimated = estimate.force ? estimate.force->norm() : 0;
    sample.model = of_depth ? offline_report->compared().back().model_at_truth : sample.truth;
    const Eigen::Vector3d& n = estimate.local_model.normal;
    const double stiffness = (estimate.local_model.stiffness * n).norm();
    if (of_depth && estimate.depth > 0) {
      sample.vision = stiffness * n.dot(truth.p_S_tip - estimate.p_S_tip);
    }
    samples.push_back(sample);
  }
  return samples;
}

// The error of two cameras without noise is the model's, the rest is the cameras'.
void AddQuietRun(const Scene& scene, const std::stop_token& stop, std::vector<Sample>* samples) {
  const Scene quiet = Changed(scene, {"site.noise=0", "site.flicker=0", "site.lighting=0"});
  const std::vector<Sample> without = RunPress(quiet, stop);
  for (std::size_t i = 0; i < std::min(samples->size(), without.size()); ++i) {
    (*samples)[i].model = without[i].estimated;
  }
}

class Rms {
 public:
  void Add(double x) { sum_ += x * x; }
  [[nodiscard]] double Over(std::size_t count) const {
    return count > 0 ? std::sqrt(sum_ / static_cast<double>(count)) : 0;
  }

 private:
  double sum_ = 0;
};

// Ticks between samples, with place and truth as they go from one to the next.
class Ticks {
 public:
  Ticks(const std::vector<Sample>& samples, double delay, bool splits)
      : samples_(samples), delay_(delay), splits_(splits) {
    for (const Sample& s : samples) peak_ = std::fmax(peak_, s.truth);
  }

  void Run() {
    std::size_t i = 0, arrived = 0;
    for (double t = delay_; i + 1 < samples_.size(); t += kTick) {
      while (i + 1 < samples_.size() && samples_[i + 1].t <= t) ++i;
      while (arrived < i && samples_[arrived + 1].t + delay_ <= t) ++arrived;
      if (i + 1 < samples_.size()) Add(i, arrived, t);
    }
  }

  EndToEndBudget Budget(const Scene& scene) const {
    EndToEndBudget budget{scene.name, 1, peak_, total_.Over(count_), delay_, {}};
    const bool fingertips = scene.sense.Find<Tactile>() != nullptr;
    budget.parts = {
        {fingertips ? "touch" : "vision", vision_.Over(count_), false,
         fingertips ? "a network trained on more contacts of this kind"
                    : "a sharper image: smaller pixels, less noise"},
        {"contact", contact_.Over(count_), false,
         "a more accurate rest surface: a sharper first image, an outline that fits the object"},
        {"model", model_.Over(count_), false, "a finer model (`model.kind: auto`, `elements`)"},
        {"rendering", rendering_.Over(count_), false,
         "a higher sample rate, slower motion of the operator"},
        {"link", link_.Over(count_), false, "a shorter delay between master and slave"},
        {"material", scene.object.material.young_modulus_tolerance * truth_.Over(count_), true,
         "a measured modulus (`palpate-slave identify`)"}};
    return budget;
  }

 private:
  void Add(std::size_t i, std::size_t arrived, double t) {
    const Sample &now = samples_[i], &next = samples_[i + 1];
    const double share = (t - now.t) / (next.t - now.t);
    const Eigen::Vector3d p_S = now.p_S_tip + share * (next.p_S_tip - now.p_S_tip);
    const double truth = now.truth + share * (next.truth - now.truth);
    const double prompt = Rendered(now.local, p_S),
                 rendered = Rendered(samples_[arrived].local, p_S);
    if (std::fmax(truth, rendered) <= kContactShare * peak_ || !std::isfinite(now.model)) return;
    ++count_;
    truth_.Add(truth);
    total_.Add(rendered - truth);
    const double sensed = now.estimated - now.model;
    vision_.Add(splits_ ? now.vision : sensed);
    contact_.Add(splits_ ? sensed - now.vision : 0);
    model_.Add(now.model - now.truth);
    rendering_.Add(prompt - truth - (now.estimated - now.truth));
    link_.Add(rendered - prompt);
  }

  const std::vector<Sample>& samples_;
  double delay_, peak_ = 0;
  bool splits_;
  std::size_t count_ = 0;
  Rms truth_, total_, vision_, contact_, model_, rendering_, link_;
};

}  // namespace

namespace {

EndToEndBudget MeasureOne(const Scene& scene, double delay, const std::stop_token& stop) {
  std::vector<Sample> samples = RunPress(scene, stop);
  if (scene.sense.Find<StereoCameras>()) AddQuietRun(scene, stop, &samples);
  Ticks ticks(samples, delay, scene.sense.Find<Camera>() != nullptr);
  ticks.Run();
  return ticks.Budget(scene);
}

// Across the way of the tool, unit, frame S.
Eigen::Vector3d Sideways(const Scene& scene) {
  if (scene.sense.Find<Camera>()) {
    const Eigen::Vector2d way = scene.tool->direction.normalized();
    return {-way.y(), way.x(), 0};
  }
  if (!IsVolume(scene.object.geometry)) return scene.object.X_SO.linear().col(0);
  const std::vector<Eigen::Vector3d> nodes = SurfaceOf(MeshObject(scene, std::nullopt)).nodes;
  Eigen::AlignedBox3d box;
  for (const Eigen::Vector3d& p_O : nodes) box.extend(p_O);
  Eigen::Index least = 0;
  (scene.object.X_SO * box.center() - scene.manipulator.home).cwiseAbs().minCoeff(&least);
  return Eigen::Vector3d::Unit(least);
}

// The scene with its contact elsewhere: the object moves below fingertips, whose poses belong to
// the manipulator's home, and home moves with any other tool.
std::vector<Scene> Elsewhere(const Scene& scene) {
  std::vector<Scene> scenes;
  if (scene.site.embryo || !IsHeld(scene.object)) return scenes;  // a needle has one way
  const Eigen::Vector3d step = study::AskedOf(scene).size * Sideways(scene);
  for (const double share : {-0.2, -0.1, 0.1, 0.2}) {
    if (scene.sense.Find<Tactile>()) {
      Eigen::Isometry3d X_SO = scene.object.X_SO;
      const std::string pose = ScenePose(X_SO.pretranslate(-share * step));  // `pose: {...}`
      scenes.push_back(Changed(scene, {"object.pose=" + pose.substr(pose.find('{'))}));
    } else {
      const Eigen::Vector3d home = scene.manipulator.home + share * step;
      scenes.push_back(Changed(scene, {fmt::format("manipulator.home=[{} m, {} m, {} m]", home.x(),
                                                   home.y(), home.z())}));
    }
  }
  return scenes;
}

void Add(const EndToEndBudget& one, EndToEndBudget* sum) {
  const auto count = static_cast<double>(++sum->presses);
  const auto take = [&](double value, double* mean) { *mean += (value - *mean) / count; };
  take(one.peak, &sum->peak);
  take(one.total, &sum->total);
  for (std::size_t i = 0; i < one.parts.size(); ++i) {
    BudgetPart& part = sum->parts[i];
    take(one.parts[i].rms, &part.rms);
    part.least = std::min(part.least, one.parts[i].rms);
    part.most = std::max(part.most, one.parts[i].rms);
  }
}

}  // namespace

const BudgetPart& EndToEndBudget::largest() const {
  return *std::ranges::max_element(parts, {}, &BudgetPart::rms);
}

EndToEndBudget MeasureEndToEnd(const Scene& scene, double delay, const std::stop_token& stop) {
  if (!(delay >= 0 && delay <= 1)) {
    throw std::invalid_argument(fmt::format("--delay = {:g} s: expected 0 to 1", delay));
  }
  EndToEndBudget budget = MeasureOne(scene, delay, stop);
  for (BudgetPart& part : budget.parts) part.least = part.most = part.rms;
  for (const Scene& other : Elsewhere(scene)) {
    try {
      const EndToEndBudget one = MeasureOne(other, delay, stop);
      if (one.total > 0 && !stop.stop_requested()) Add(one, &budget);
    } catch (const std::invalid_argument&) {  // the tool does not meet the object there
    }
  }
  return budget;
}

}  // namespace palpate
