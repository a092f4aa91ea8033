// One kind of sensing, with a camera, with points on the object or with fingertips: waits for a
// sample, estimates the contact and derives further results. Slaves and offline runs use only this
// interface.
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
#include "slave/capture/frame_source.h"
#include "slave/capture/image_inbox.h"
#include "slave/capture/sense_inputs.h"
#include "slave/pipeline/base/sense_types.h"
#include "slave/program/progress.h"
#include "slave/program/stopwatch.h"
#include "slave/scene/model_kinds.h"
#include "slave/scene/scene.h"

namespace palpate {

class OfflineReport;
class LatencyHistogram;
class GroundTruth;
class TactileInbox;

// Returns `times` as those of the stage `name`.
StageTimes TimesOf(const std::string& name, const LatencyHistogram& times);

// Returns `model` with the requested change. `object`: class whose kinds are accepted; nullopt:
// there is no model. Throws std::invalid_argument with what is accepted.
ModelOptions Changed(ModelOptions model, const ModelChange& change,
                     std::optional<ObjectClass> object);

void Append(std::vector<float>* out, const Eigen::Vector3d& v);
// Adds a node of a field: its rest position and displacement, frame O [m], and the displaced
// position in the image [px].
void Append(DisplacementField* field, const Eigen::Vector3d& p_O, const Eigen::Vector3d& u_O,
            const Eigen::Vector2d& p_I);
// A shape without vertices, of `estimated`.
inline BoundaryShape ShapeAsOf(const ContactEstimate& estimated, int nodes_per_element) {
  return {estimated.sample,
          estimated.sensed_at,
          estimated.validity,
          nodes_per_element,
          {},
          {},
          {},
          {},
          {},
          {},
          {}};
}

// The last image and how to draw the results into it: cheap to copy, expensive to draw.
struct OverlaidImage {
  Time sensed_at{};
  cv::Mat plain;  // 8 bit
  std::function<cv::Mat()> draw;
};

// Motion of the whole surface since it was found, S.
struct SurfaceMotion {
  Eigen::Vector3d offset{0, 0, 0};    // [m]
  Eigen::Vector3d velocity{0, 0, 0};  // [m/s]
  double velocity_error = 0;          // one standard deviation [m/s]
};

// Tip position from the manipulator's encoders at the time of a sample.
struct TipReading {
  Eigen::Vector3d p_S_tip{0, 0, 0};  // [m]
  // Number of the encoders' origin, see Manipulator::frame; nullopt: the sample does not show the
  // tool that they measure, so the sensing is not compared with them.
  std::optional<std::uint32_t> frame;
};

// The parts that a change of settings replaces together: a model and its data.
class PreparedModel {
 public:
  virtual ~PreparedModel() = default;
  [[nodiscard]] virtual const ModelInfo& info() const = 0;
};

// One line each, as `serve` and `process` print it.
std::vector<std::string> Introduction(const SenseInfo& info);

// No function has a default: a wrapper that forgets one does not compile.
//
// One thread acquires, processes and estimates. Every other call may come from another thread, but
// not at the same time as another call or Estimate. Only Prepare may run at any time.
class SensingPipeline {
 public:
  virtual ~SensingPipeline() = default;
  SensingPipeline() = default;
  SensingPipeline(const SensingPipeline&) = delete;
  SensingPipeline& operator=(const SensingPipeline&) = delete;

  // Waits for the next sample. False: the source has ended, or `stop`. Throws std::runtime_error
  // where the source breaks.
  virtual bool Acquire(const std::stop_token& stop) = 0;
  // The long part that is independent of other threads: extracts from the sample the measurements
  // for the estimate.
  virtual void Process() noexcept = 0;
  // Estimate from the acquired sample. `encoders`: at sensed_at(). Allocation-free after the first
  // ones; unknown values are flagged.
  virtual const ContactEstimate& Estimate(const TipReading& encoders) noexcept = 0;
  // Why the model's last estimate is extrapolated, one clause with static lifetime; empty: it is
  // not, or unknown.
  [[nodiscard]] virtual std::string_view flag_reason() const = 0;
  // The contact that the master renders for a tip at p_S_tip [m] now, between samples too.
  virtual LocalModel LocalModelAt(const Eigen::Vector3d& p_S_tip) noexcept = 0;
  // Makes the patch of surface and compliance around a tip at p_S_tip [m], without epoch and
  // revision. Returns false if this sensing has none. It may take milliseconds.
  virtual bool MakePatch(const Eigen::Vector3d& p_S_tip, SurfacePatch* patch) noexcept = 0;
  // Returns whether data learnt since the last MakePatch would change the patch perceptibly.
  [[nodiscard]] virtual bool HasOutgrownPatch() const noexcept = 0;
  // Sets the learnt part of the curve. Only its known fields are set.
  virtual void LearnLaw(PatchLaw* law) noexcept = 0;
  // The motion at the last estimate. Patches refer to the surface where it was found.
  [[nodiscard]] virtual SurfaceMotion motion() const noexcept = 0;
  // The shape at the last estimate.
  virtual BoundaryShape Shape(const ShapeParts& parts) = 0;
  // `full_scale`: the largest force that the device can render, at the tool [N]. nullopt: no
  // camera, or no image yet.
  [[nodiscard]] virtual std::optional<OverlaidImage> Image(double full_scale) const = 0;

  // Builds the parts that depend on changed settings, which may take long; the result may be null.
  // Throws std::invalid_argument naming the key; Interrupted, if `progress` (may be null) requests
  // a stop.
  [[nodiscard]] virtual std::unique_ptr<PreparedModel> Prepare(const Scene& changed,
                                                               Progress* progress) const = 0;
  // Uses the prepared parts from now on.
  virtual void Adopt(std::unique_ptr<PreparedModel> prepared, const Scene& changed) = 0;
  // Clears the contact and measures the baseline again: nothing must be in contact. Between Acquire
  // and Process only. A measurement that takes several samples ends without a result as soon as
  // `is_disengaged` returns false; what it refers to outlives the sensing.
  virtual void Reset(const std::function<bool()>& is_disengaged) = 0;

  [[nodiscard]] virtual SenseInfo info() const = 0;
  [[nodiscard]] virtual std::vector<StageTimes> Stages() const = 0;
  // The report of a run with this sensing, which must outlive it. `truth`: null where it is
  // unknown.
  virtual std::unique_ptr<OfflineReport> OpenOfflineReport(const GroundTruth* truth) = 0;
  // Receiver of streamed samples; null: none.
  [[nodiscard]] virtual TactileInbox* inbox() = 0;
  // Receiver of streamed images; null: none.
  [[nodiscard]] virtual ImageInbox* image_inbox() = 0;
  // Time of the acquired sample. For the thread that acquires.
  [[nodiscard]] virtual Time sensed_at() const = 0;
  // Status of live cameras; nullopt: none. Thread-safe.
  [[nodiscard]] virtual std::optional<CameraHealth> health() const = 0;
};

// The sensing of the scene. Throws std::runtime_error or std::invalid_argument: a source that
// cannot be opened, an object that is not found, or one that cannot be modelled.
std::unique_ptr<SensingPipeline> MakeSensingPipeline(const Scene& scene,
                                                     const SenseInputs& inputs = {});

}  // namespace palpate
