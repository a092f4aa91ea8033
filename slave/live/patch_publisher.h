// Publishes the surface patch: builds one at the tool, and sends a new force-depth curve when the
// master's force would differ perceptibly from the estimate. A curve that was learnt during a
// contact is sent at its end, for the next one.
#pragma once

#include <atomic>
#include <mutex>
#include <optional>

#include "shared/link/priority_inheritance_mutex.h"
#include "shared/patch/patch_contact.h"
#include "shared/state/slave_state.h"
#include "slave/live/slave.h"
#include "slave/pipeline/base/sensing_pipeline.h"
#include "slave/pipeline/local_model/force_law.h"

namespace palpate {

// Does no work without requests. Update: one thread, with no other calls to the sensing at the same
// time; Get: any thread.
class PatchPublisher {
 public:
  static constexpr double kWanted = 2;         // time since the last request [s]
  static constexpr double kMinPeriod = 0.030;  // time between two curves [s]

  struct Options {
    double weber_fraction = 0.1;  // of the force [-]
    double depth = 0.005;         // range of a curve without an object model [m]
    double period = 1.0 / 60;     // of the samples [s]
  };
  explicit PatchPublisher(const Options& options)
      : options_(options), learnt_law_(options.depth, options.period) {}

  // Returns the newest patch; empty: none yet. Requests keep it up to date.
  [[nodiscard]] PatchSnapshot Get(Time now);
  // Call it after each sample.
  void Update(const ContactEstimate& estimate, std::uint32_t settings_revision,
              SensingPipeline* sense, Time now);

 private:
  [[nodiscard]] bool IsLeft(const Eigen::Vector3d& p_S) const noexcept;
  void Renew(const ContactEstimate& estimate, std::uint32_t settings_revision,
             SensingPipeline* sense);
  void Compare(const ContactEstimate& estimate, SensingPipeline* sense, Time now);
  // The present curve, and its plane if the sensing made no patch.
  void FillLaw(const ContactEstimate& estimate, SensingPipeline* sense, SurfacePatch* plane,
               PatchLaw* law) const;
  void Put(const SurfacePatch& patch, PatchLaw law);

  const Options options_;
  ForceLaw learnt_law_;
  std::atomic<Time> asked_at_{Time{}};
  // The contact as the master computes it from the sent patch and curve.
  PatchContact shown_;
  bool is_learnt_ = false;           // the patch is the plane of a learnt curve
  Eigen::Vector3d centre_{0, 0, 0};  // tip when the patch was made, on it [m]
  double reach_ = 0;                 // of the patch from there [m]
  Time published_at_{};
  bool pressed_ = false;  // time since the curve was last checked

  mutable PriorityInheritanceMutex mutex_;  // guards the members below
  PatchSnapshot news_;
};

}  // namespace palpate
