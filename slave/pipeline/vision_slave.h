// The slave that feels with a camera: ties source, estimator, manipulator and operator together.
#pragma once

#include <functional>
#include <memory>
#include <mutex>
#include <optional>
#include <string>
#include <thread>
#include <vector>

#include "slave/manipulator/manipulator.h"
#include "slave/pipeline/estimator.h"
#include "slave/pipeline/newest_felt.h"
#include "slave/pipeline/operator_port.h"
#include "slave/pipeline/operator_watch.h"
#include "slave/pipeline/slave.h"
#include "slave/pipeline/tip_registration.h"
#include "slave/site/simulated_site.h"

namespace palpate {

// Threads: one for the camera, which owns the estimator under `touch_mutex_`, one that watches the
// operator. What they share with callers is `newest_` and the newest picture.
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
  // Makes the model of `changed` and puts it to work unless `may_adopt` throws just before.
  void Rebuild(const Scene& changed, const std::function<void()>& may_adopt);
  [[nodiscard]] Scene scene() const;

  std::mutex change_mutex_;  // one change of settings at a time; held while a model is made
  mutable std::mutex settings_mutex_;  // never held long; guards the next three
  Scene scene_;                        // with the parameters in force
  std::string model_reason_;
  ModelInfo model_info_;
  std::unique_ptr<SimulatedSite> site_;  // null where the site is real
  std::unique_ptr<Manipulator> manipulator_;
  std::unique_ptr<FrameSource> source_;
  std::unique_ptr<OperatorPort> port_;
  Time started_at_;
  Registration registration_;

  mutable std::mutex touch_mutex_;  // guards the estimator
  std::unique_ptr<Estimator> estimator_;
  TipRegistration tip_registration_;

  NewestFelt newest_;

  mutable std::mutex picture_mutex_;  // guards what follows
  Frame newest_frame_;
  Observation newest_observation_;
  std::vector<Eigen::Vector2d> newest_contour_I_;
  cv::Rect newest_window_;

  std::jthread picture_thread_;
  std::optional<OperatorWatch> operator_watch_;
};

}  // namespace palpate
