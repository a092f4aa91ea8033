// Keeps the patch that travels: makes one where the tool comes, and tells the law anew when what
// the master shows differs from what is felt by more than a hand feels; and what was learnt in a
// press when it ends, for the next one.
#pragma once

#include <atomic>
#include <mutex>
#include <optional>

#include "shared/patch/patch_contact.h"
#include "shared/state/slave_state.h"
#include "slave/pipeline/local_model/force_law.h"
#include "slave/pipeline/sensing_pipeline.h"
#include "slave/pipeline/teleop/slave.h"

namespace palpate {

// Costs nothing while nobody asks. Update: one thread, with the sense's other callers kept away;
// Get: any.
class PatchPublisher {
 public:
  static constexpr double kWanted = 2;        // since somebody asked [s]
  static constexpr double kShortest = 0.030;  // between two laws [s]

  struct Options {
    double weber_fraction = 0.1;  // of the force [-]
    double depth = 0.005;         // that a law without an object is told over [m]
    double period = 1.0 / 60;     // of the samples [s]
  };
  explicit PatchPublisher(const Options& options)
      : options_(options), felt_law_(options.depth, options.period) {}

  // The newest; empty: none yet. Whoever asks wants it to be kept up.
  [[nodiscard]] PatchSnapshot Get(Time now);
  // After each sample.
  void Update(const ContactEstimate& felt, std::uint32_t settings_revision, SensingPipeline* sense,
              Time now);

 private:
  [[nodiscard]] bool IsLeft(const Eigen::Vector3d& p_S) const noexcept;
  void Renew(const ContactEstimate& felt, std::uint32_t settings_revision, SensingPipeline* sense);
  void Compare(const ContactEstimate& felt, SensingPipeline* sense, Time now);
  // The law as of now, and the plane that it belongs to where no sense made a patch.
  void FillLaw(const ContactEstimate& felt, SensingPipeline* sense, SurfacePatch* plane,
               PatchLaw* law) const;
  void Put(const SurfacePatch& patch, PatchLaw law);

  const Options options_;
  ForceLaw felt_law_;
  std::atomic<Time> asked_at_{Time{}};
  // What the master shows by what it was told.
  PatchContact shown_;
  bool is_felt_ = false;             // the patch is the felt law's plane
  Eigen::Vector3d centre_{0, 0, 0};  // where the tip was when the patch was made, on it [m]
  double reach_ = 0;                 // of the patch from there [m]
  Time told_at_{};
  bool pressed_ = false;  // since the law was looked at last

  mutable std::mutex mutex_;  // guards what follows
  PatchSnapshot news_;
};

}  // namespace palpate
