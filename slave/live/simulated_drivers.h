// The drivers of a simulated scene: they send samples from palpate-simulator to a slave with a
// driven clock.
#pragma once

#include <cstdint>
#include <optional>
#include <string>
#include <vector>

#include <Eigen/Core>

#include "palpate/v1/simulation.pb.h"

#include "slave/live/slave.h"
#include "slave/scene/scene.h"

namespace palpate {

class SimulatedDrivers {
 public:
  static constexpr std::uint64_t kId = 1;  // number of each stream

  // `slave` has the same scene and outlives them.
  explicit SimulatedDrivers(Slave& slave) : slave_(slave) {}

  // Sends the manipulator's reports up to the sample, along a line from its last position, then the
  // sample. The driven clock then shows the sample's time. Throws std::runtime_error with the
  // reason if the slave refuses a message.
  void Send(const v1::SimulatedSample& sample);
  void SendReports(const v1::SimulatedTruth& truth, Time sensed_at);
  void SendImages(const v1::ImageSample& images);
  void SendTactile(const v1::TactileSample& sample);

 private:
  void Report(const Eigen::Vector3d& p_S_tip, Time at, const v1::SimulatedTruth* truth);

  Slave& slave_;
  std::uint64_t reports_ = 0;
  Eigen::Vector3d p_S_tip_{0, 0, 0};  // of the last report [m]
  Time reported_at_{};                // driver's clock
};

}  // namespace palpate
