// One way of feeling, with a camera, with points on the object or with fingertips: waits for a
// sample, makes an estimate of it, and tells what else follows from it. Slaves and runs without an
// operator see only this.
#pragma once

#include <cstdint>
#include <functional>
#include <memory>
#include <optional>
#include <stop_token>
#include <string>
#include <string_view>
#include <vector>

#include <Eigen/Core>
#include <opencv2/core/mat.hpp>

#include "shared/state/slave_state.h"
#include "shared/state/surface_patch.h"
#include "shared/telemetry/stopwatch.h"
#include "shared/text/progress.h"
#include "slave/capture/picture_inbox.h"
#include "slave/mechanics/deformation_model.h"
#include "slave/scene/model_kinds.h"
#include "slave/scene/scene.h"
#include "slave/site/simulated_environment.h"

namespace palpate {

class OfflineReport;
class LatencyHistogram;
class TactileInbox;

struct StageTimes {
  std::string stage;
  double p50_us = 0, p99_us = 0, max_us = 0;
};
// `times` as the stage called `name`.
StageTimes TimesOf(const std::string& name, const LatencyHistogram& times);

// A change of SetModel; empty or 0: as it is.
struct ModelChange {
  std::string kind;
  int elements = 0;
  std::string plane, contact;
};
// What of a model may change while it runs.
struct Changeable {
  std::optional<ObjectClass> object;  // whose kinds it takes; nullopt: there is no model
  int most_elements = 0;              // 3 to so many; 0: the mesh is the scene's
  bool plane = false, contact = false;
};
// `model` with what is asked for. Throws std::invalid_argument, what is accepted.
ModelOptions Changed(ModelOptions model, const ModelChange& change, const Changeable& accepted);

// The deformed boundary: its vertices, frame S [m].
struct BoundaryShape {
  std::uint64_t state_sequence = 0;
  Time sensed_at{};
  Validity validity = Validity::kFailed;
  int nodes_per_element = 2;            // 2: lines of a planar object, 3: triangles
  std::vector<std::uint32_t> elements;  // vertex indices, `nodes_per_element` at a time
  std::vector<float> rest, positions;   // x, y, z per vertex
  std::vector<float>
      nodal_forces;  // x, y, z per vertex, of the tool on the object [N]; empty unless asked for
  // Of the tool on the object, its size per vertex [Pa], where the model tells more than the forces
  // on the nodes do; empty where not, and unless those were asked for.
  std::vector<float> traction;
  std::vector<std::uint32_t> fixed_nodes;  // vertices that the scene holds, along one axis at least
};
void Append(std::vector<float>* out, const Eigen::Vector3d& v);
// Without a vertex, as of `felt`.
inline BoundaryShape ShapeAsOf(const ContactEstimate& felt, int nodes_per_element) {
  return {felt.sample, felt.sensed_at, felt.validity, nodes_per_element, {}, {}, {}, {}, {}, {}};
}

// What was seen last and how to draw into it what was made of it: cheap to take, costly to draw.
struct SeenPicture {
  Time sensed_at{};
  cv::Mat plain;  // 8 bit
  std::function<cv::Mat()> draw;
};

// Of the whole surface since it was found, S.
struct SurfaceMotion {
  Eigen::Vector3d offset{0, 0, 0};    // [m]
  Eigen::Vector3d velocity{0, 0, 0};  // [m/s]
  double velocity_error = 0;          // one standard deviation [m/s]
};

// What a change of settings rebuilds as a whole: a model and what goes with it.
class PreparedModel {
 public:
  virtual ~PreparedModel() = default;
  [[nodiscard]] virtual const ModelInfo& info() const = 0;
};

// What feels, for people and for those who must know how far it goes.
struct SenseInfo {
  std::string source;   // of samples
  std::string samples;  // what they are: pictures, pairs, samples
  // Of the tip's place as it is sensed [m]; 0: only the manipulator says where it is.
  double tip_resolution = 0;
  bool tells_force = true;           // false: the object's place alone
  ModelInfo model;                   // kind `none`: there is none
  std::string reason;                // why this model
  std::vector<std::string> remarks;  // what to know before the first touch, a sentence each
  Changeable changeable;
  bool is_awaited = false;  // nothing came yet: model and remarks are not known
};

// A line each, as `serve` and `process` say it.
std::vector<std::string> Introduction(const SenseInfo& info);

// One thread acquires, looks, estimates; every other call may come from another one, but not at
// the same time as each other or Estimate. Prepare alone may run beside anything.
class SensingPipeline {
 public:
  virtual ~SensingPipeline() = default;
  SensingPipeline() = default;
  SensingPipeline(const SensingPipeline&) = delete;
  SensingPipeline& operator=(const SensingPipeline&) = delete;

  // Waits for the next sample. False: the source has ended, or `stop`. Throws std::runtime_error
  // where the source breaks.
  virtual bool Acquire(const std::stop_token& stop) = 0;
  // What takes long and needs nobody else: finds in the sample what the estimate is made of.
  virtual void Process() noexcept {}
  // Of the acquired sample. `p_S_tip`: where the manipulator says the tip was when it came [m].
  // Allocation-free after the first ones; what cannot be known is flagged.
  virtual const ContactEstimate& Estimate(const Eigen::Vector3d& p_S_tip) noexcept = 0;
  // Why what the model said for the last estimate is extrapolated, one clause that lives on; empty:
  // it is not, or nobody knows.
  [[nodiscard]] virtual std::string_view doubt() const { return {}; }
  // The contact that the master renders for a tip at p_S_tip [m] now, between samples too.
  virtual LocalModel LocalModelAt(const Eigen::Vector3d& p_S_tip) noexcept = 0;
  // The surface around a tip at p_S_tip [m] and how it gives way, without epoch and revision.
  // False: this sense has none. It may take milliseconds.
  virtual bool MakePatch(const Eigen::Vector3d& /*p_S_tip*/, SurfacePatch* /*patch*/) noexcept {
    return false;
  }
  // What of it was learnt by feeling: nothing as a rule. Of the law only what the sense knows.
  virtual void LearnLaw(PatchLaw* /*law*/) noexcept {}
  // As of the last estimate; patches are of the surface where it was found.
  [[nodiscard]] virtual SurfaceMotion motion() const noexcept { return {}; }
  // As of the last estimate.
  virtual BoundaryShape Shape(bool nodal_forces) = 0;
  // `full_scale`: the largest force that the hand can show, at the tool [N]. nullopt: no camera, or
  // nothing was seen yet.
  [[nodiscard]] virtual std::optional<SeenPicture> Picture(double /*full_scale*/) const {
    return std::nullopt;
  }

  // Builds for changed settings what depends on them, which takes its time; may be null. Throws
  // std::invalid_argument naming the key; Interrupted, as `progress` wants it, which may be null.
  [[nodiscard]] virtual std::unique_ptr<PreparedModel> Prepare(const Scene& changed,
                                                               Progress* progress) const = 0;
  // Puts it to work.
  virtual void Adopt(std::unique_ptr<PreparedModel> prepared, const Scene& changed) = 0;
  // What was felt is forgotten, rest values are taken anew: nothing must touch. Between Acquire and
  // Process only.
  virtual void Reset() = 0;

  [[nodiscard]] virtual SenseInfo info() const = 0;
  [[nodiscard]] virtual std::vector<StageTimes> Stages() const = 0;
  // Keeps the account of a run over this sense, which must outlive it; `environment` may be null.
  virtual std::unique_ptr<OfflineReport> OpenOfflineReport(
      const SimulatedEnvironment* environment) = 0;
  // Where streamed samples go; null: it takes none.
  [[nodiscard]] virtual TactileInbox* inbox() { return nullptr; }
  // Where streamed pictures go; null: it takes none.
  [[nodiscard]] virtual PictureInbox* pictures() { return nullptr; }
  // When the acquired sample was taken; now, of what comes without delay. Thread-safe.
  [[nodiscard]] virtual Time sensed_at() const { return Clock::now(); }
  // Of live eyes; nullopt: it has none. Thread-safe.
  [[nodiscard]] virtual std::optional<CameraHealth> health() const { return std::nullopt; }
};

// The sense of the scene. `environment`: what it senses, and outlives it; null: the real one.
// Throws std::runtime_error or std::invalid_argument: what cannot be opened, found or modelled.
std::unique_ptr<SensingPipeline> MakeSensingPipeline(const Scene& scene, const Pace& pace,
                                                     SimulatedEnvironment* environment);

}  // namespace palpate
