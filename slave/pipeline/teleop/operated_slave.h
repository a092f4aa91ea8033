// What all slaves have in common: an operator who moves a tool, the newest felt state, settings
// that change while it runs. What senses and feels is added by those who derive.
#pragma once

#include <functional>
#include <memory>
#include <mutex>
#include <optional>
#include <string>
#include <thread>
#include <vector>

#include "shared/telemetry/latency_histogram.h"
#include "slave/manipulator/simulated_manipulator.h"
#include "slave/pipeline/teleop/command_watchdog.h"
#include "slave/pipeline/teleop/latest_estimate.h"
#include "slave/pipeline/teleop/operator_port.h"
#include "slave/pipeline/teleop/slave.h"

namespace palpate {

// `h` as a stage of Status().
StageTimes TimesOf(const std::string& name, const LatencyHistogram& h);

// Threads: one senses, one moves the tool, one watches the operator. `touch_mutex()` guards what
// the first one shares with callers beyond the newest felt state: the estimator of whoever derives.
class OperatedSlave : public Slave {
 public:
  ~OperatedSlave() override;

  void BeginOperating() override;
  bool Command(const OperatorCommand& command) noexcept override;
  void EndOperating() override;
  [[nodiscard]] SlaveState Compose(Time now) override;
  Events TakeEvents() override;
  bool WaitForNewer(Time sensed_at, std::chrono::milliseconds patience) override;
  [[nodiscard]] SlaveDescription Describe() const override;
  [[nodiscard]] SlaveStatus Status() const override;
  void SetModel(const ModelChange& change) override;
  void SetParameters(const ParameterChange& change) override;
  void Reset() override;
  void EmergencyStop(const std::string& reason) override;

 protected:
  // `sensor_rate` as LatestEstimate has it [Hz].
  OperatedSlave(const Scene& scene, double sensor_rate);

  // The tool begins to move; `on_step` as SimulatedManipulator has it. What it uses must outlive
  // this object.
  void StartTool(const SimulatedManipulator::OnStep& on_step);
  // Tells what runs, before anybody asks.
  void SetRunning(const ModelInfo& model, const std::string& reason);
  // Calls `sense` in a thread of its own, again and again, until it returns false or throws: the
  // source has ended, or broken, which is an alarm. Watches the operator from now on.
  void StartSensing(std::function<bool(const std::stop_token&)> sense);
  // Call first of all where one is destroyed who gave `sense`.
  void StopSensing();

  // --- what is asked of those who derive
  [[nodiscard]] virtual bool is_simulated() const = 0;
  [[nodiscard]] virtual std::string SourceDescription() const = 0;
  // Of the object on the tool now, where the site knows it [N].
  [[nodiscard]] virtual std::optional<Eigen::Vector3d> TrueForce() const = 0;
  // Under touch_mutex().
  [[nodiscard]] virtual std::vector<StageTimes> Stages() const = 0;
  // Under touch_mutex(): what was felt is forgotten, rest values are taken anew.
  virtual void ResetSenses() = 0;
  // `model` with what is asked for; throws std::invalid_argument, what is accepted.
  virtual void Apply(const ModelChange& change, ModelOptions* model) const = 0;
  // Makes the model of `changed`, which takes its time; calls `may_adopt`, which may throw; puts
  // the model to work under touch_mutex().
  virtual ModelInfo Replace(const Scene& changed, const std::function<void()>& may_adopt) = 0;

  [[nodiscard]] Scene scene() const;  // with the parameters now in force
  // The largest force that the hand can show, at the tool [N].
  [[nodiscard]] double FullScale() const;
  [[nodiscard]] std::mutex& touch_mutex() const { return touch_mutex_; }
  [[nodiscard]] Manipulator& manipulator() { return *manipulator_; }
  [[nodiscard]] const Manipulator& manipulator() const { return *manipulator_; }
  [[nodiscard]] OperatorPort& port() { return *port_; }
  [[nodiscard]] LatestEstimate& newest() { return newest_; }
  [[nodiscard]] const LatestEstimate& newest() const { return newest_; }

 private:
  void Rebuild(const Scene& changed, const std::function<void()>& may_adopt);

  std::mutex change_mutex_;  // one change of settings at a time; held while a model is made
  mutable std::mutex settings_mutex_;  // never held long; guards the next three
  Scene scene_;                        // with the parameters in force
  std::string model_reason_;
  ModelInfo model_info_;
  const Time started_at_ = Clock::now();
  mutable std::mutex touch_mutex_;
  std::unique_ptr<Manipulator> manipulator_;
  std::unique_ptr<OperatorPort> port_;
  LatestEstimate newest_;
  std::jthread sensing_;
  std::optional<CommandWatchdog> operator_watch_;
};

}  // namespace palpate
