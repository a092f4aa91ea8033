// The slave that feels with tactile fingertips: ties source, estimator, manipulator and operator
// together (paper B).
#pragma once

#include <functional>
#include <memory>
#include <mutex>
#include <optional>
#include <string>
#include <thread>

#include "slave/manipulator/manipulator.h"
#include "slave/pipeline/newest_felt.h"
#include "slave/pipeline/operator_port.h"
#include "slave/pipeline/operator_watch.h"
#include "slave/pipeline/slave.h"
#include "slave/pipeline/tactile_estimator.h"
#include "slave/site/fingertip/tactile_site.h"

namespace palpate {

// Threads: one for the samples, which owns the estimator under `touch_mutex_`, one that watches the
// operator. What they share with callers is `newest_`.
class TactileSlave final : public Slave {
 public:
  // Loads the network, precomputes the object's model, opens the source, starts; the first samples
  // are rest values, so until they are known the force is unknown. Throws std::runtime_error or
  // std::invalid_argument: what cannot be loaded, modelled or opened.
  explicit TactileSlave(Scene scene);
  // The same with another source and other senses than the scene's; for tests.
  TactileSlave(Scene scene, std::unique_ptr<TactileSource> source, TactileSenses senses);
  ~TactileSlave() override;

  void BeginOperating() override;
  bool Command(const OperatorCommand& command) noexcept override;
  void EndOperating() override;
  [[nodiscard]] SlaveState Compose(Time now) override;
  Events TakeEvents() override;
  bool WaitForNewer(Time sensed_at, std::chrono::milliseconds patience) override;
  [[nodiscard]] SlaveDescription Describe() const override;
  [[nodiscard]] SlaveStatus Status() const override;
  // Kinds of volumes; `elements` and `plane` are not theirs.
  void SetModel(const ModelChange& change) override;
  void SetParameters(const ParameterChange& change) override;
  // Rest values are taken anew: nothing must touch the fingertips.
  void Reset() override;
  void EmergencyStop(const std::string& reason) override;
  [[nodiscard]] BoundaryShape Shape(bool nodal_forces) override;
  // Never a picture: there is no camera.
  [[nodiscard]] std::optional<JpegPicture> Picture(bool overlays, int quality) override;
  [[nodiscard]] TactileInbox* tactile_inbox() override;

 private:
  void OpenSource();
  void Start();
  void WatchSamples(const std::stop_token& stop);
  void Rebuild(const Scene& changed, const std::function<void()>& may_adopt);
  [[nodiscard]] Scene scene() const;

  std::mutex change_mutex_;  // one change of settings at a time; held while a model is made
  mutable std::mutex settings_mutex_;  // never held long; guards the next three
  Scene scene_;                        // with the parameters in force
  std::string model_reason_;
  ModelInfo model_info_;
  Time started_at_ = Clock::now();

  mutable std::mutex touch_mutex_;  // guards the estimator
  TactileEstimator estimator_;

  std::unique_ptr<TactileSite> site_;  // null where the site is real
  std::unique_ptr<Manipulator> manipulator_;
  std::unique_ptr<TactileSource> source_;
  std::unique_ptr<OperatorPort> port_;
  NewestFelt newest_;

  std::jthread sample_thread_;
  std::optional<OperatorWatch> operator_watch_;
};

}  // namespace palpate
