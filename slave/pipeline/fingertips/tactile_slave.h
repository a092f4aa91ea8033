// The slave that feels with tactile fingertips: ties source, estimator and operated hand together
// (paper B).
#pragma once

#include <functional>
#include <memory>
#include <optional>
#include <set>
#include <string>
#include <string_view>
#include <vector>

#include "slave/pipeline/fingertips/tactile_estimator.h"
#include "slave/pipeline/teleop/operated_slave.h"
#include "slave/site/fingertips/tactile_site.h"

namespace palpate {

// The samples' thread owns the estimator under touch_mutex().
class TactileSlave final : public OperatedSlave {
 public:
  // Loads the network, precomputes the object's model, opens the source, starts; the first samples
  // are rest values, so until they are known the force is unknown. Throws std::runtime_error or
  // std::invalid_argument: what cannot be loaded, modelled or opened.
  explicit TactileSlave(const Scene& scene);
  // The same with another source and other senses than the scene's; for tests.
  TactileSlave(const Scene& scene, std::unique_ptr<TactileSource> source, TactileSenses senses);
  ~TactileSlave() override;

  [[nodiscard]] BoundaryShape Shape(bool nodal_forces) override;
  // Never a picture: there is no camera.
  [[nodiscard]] std::optional<JpegPicture> Picture(bool overlays, int quality) override;
  [[nodiscard]] TactileInbox* tactile_inbox() override;

 private:
  void OpenSource(const Scene& scene);
  void Start(const Scene& scene);
  [[nodiscard]] bool is_simulated() const override { return site_ != nullptr; }
  [[nodiscard]] std::string SourceDescription() const override { return source_->description(); }
  [[nodiscard]] std::optional<Eigen::Vector3d> TrueForce() const override;
  [[nodiscard]] std::vector<StageTimes> Stages() const override;
  // Nothing must touch the fingertips.
  void ResetSenses() override { estimator_.Reset(); }
  // Kinds of volumes; `elements` and `plane` are not theirs.
  void Apply(const ModelChange& change, ModelOptions* model) const override;
  ModelInfo Replace(const Scene& changed, const std::function<void()>& may_adopt) override;

  TactileEstimator estimator_;
  std::shared_ptr<TactileSite> site_;  // null where the site is real; the hand moves in it too
  std::unique_ptr<TactileSource> source_;
  std::set<std::string_view> told_doubts_;  // of the shape, each an alarm once
};

}  // namespace palpate
