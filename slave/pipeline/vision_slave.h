// The slave that feels with a camera: ties source, estimator, manipulator and operator together.
#pragma once

#include <condition_variable>
#include <functional>
#include <memory>
#include <mutex>
#include <string>
#include <thread>
#include <vector>

#include "slave/manipulator/manipulator.h"
#include "slave/pipeline/estimator.h"
#include "slave/pipeline/operator_port.h"
#include "slave/pipeline/slave.h"
#include "slave/pipeline/tip_registration.h"
#include "slave/site/simulated_site.h"

namespace palpate {

// Threads: one for the camera, which owns the estimator under `touch_mutex_`, one that watches the
// operator. What they share with callers is `newest_` under `newest_mutex_`.
class VisionSlave : public Slave {
 public:
  // Opens the source, looks at the first picture, precomputes the model, starts. Throws
  // std::runtime_error or std::invalid_argument: what cannot be opened, found or modelled.
  explicit VisionSlave(Scene scene);
  ~VisionSlave() override;

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
  [[nodiscard]] BoundaryShape Shape(bool nodal_forces) override;
  [[nodiscard]] std::optional<JpegPicture> Picture(bool overlays, int quality) override;

  // How the rest surface was found.
  [[nodiscard]] const Registration& registration() const { return registration_; }

 private:
  void WatchPictures(const std::stop_token& stop);
  void Publish(const Frame& frame, const Felt& felt, const Eigen::Vector3d& p_S_encoders);
  void WatchOperator(const std::stop_token& stop);
  void RaiseAlarm(const std::string& text);
  // Makes the model of `changed` and puts it to work unless `may_adopt` throws just before.
  void Rebuild(const Scene& changed, const std::function<void()>& may_adopt);
  void RefuseWhileFollowing() const;
  [[nodiscard]] Scene scene() const;

  std::mutex change_mutex_;  // one change of settings at a time; held while a model is made
  mutable std::mutex settings_mutex_;    // never held long; guards scene_ and model_reason_
  Scene scene_;                          // with the parameters in force
  const double sensor_rate_;             // [Hz]
  std::unique_ptr<SimulatedSite> site_;  // null where the site is real
  std::unique_ptr<Manipulator> manipulator_;
  std::unique_ptr<FrameSource> source_;
  std::unique_ptr<OperatorPort> port_;
  std::string model_reason_;
  Time started_at_;
  Registration registration_;

  mutable std::mutex touch_mutex_;  // guards the estimator
  std::unique_ptr<Estimator> estimator_;
  TipRegistration tip_registration_;

  mutable std::mutex newest_mutex_;  // guards what follows
  std::condition_variable newest_changed_;
  Felt newest_;
  Frame newest_frame_;
  Observation newest_observation_;
  std::vector<Eigen::Vector2d> newest_contour_I_;
  cv::Rect newest_window_;
  Events events_;
  std::vector<std::string> alarms_;
  std::uint64_t frames_ = 0;
  std::vector<Time> recent_frames_;  // ring of the last second's stamps
  ModelInfo model_info_;

  std::jthread picture_thread_;
  std::jthread operator_thread_;
};

}  // namespace palpate
