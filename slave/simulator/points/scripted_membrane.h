// A simulator with scripted contacts, pair after pair on its own clock: the source of `process`
// without a recording.
#pragma once

#include <cstdint>
#include <vector>

#include "slave/capture/frame_source.h"
#include "slave/simulator/points/stereo_site.h"

namespace palpate {

struct MembraneScript {
  int rest = 15;               // pairs before the contact: the rest shape
  int dwell = 6;               // pairs at each step on the way in; one on the way back
  double target_seconds = 10;  // of a textured target's path
};

// The tool waits at manipulator.home, then moves straight down to the point below it: contact, and
// on in steps of 0.5 mm to operator.press.depth; back in the same steps, and home. A press depth
// under 1 mm or over 50 mm is divided into ten steps. A textured target needs no tool: its path
// lasts `target_seconds`.
class ScriptedMembrane final : public StereoSource {
 public:
  static constexpr double kStep = 0.5e-3;  // [m]

  // `site` of that scene must outlive this. Throws std::invalid_argument naming the key: home is
  // not above the membrane.
  ScriptedMembrane(StereoSite& site, const Scene& scene, const MembraneScript& script = {});

  // As fast as it can be computed; sensed_at counts from Time{}.
  std::optional<StereoPair> Next(const std::stop_token& stop) override;
  [[nodiscard]] std::string description() const override;

  [[nodiscard]] std::size_t pairs() const { return script_.size(); }
  // Of the last pair: the step on the way in, 0 touching; -1: at rest, on the way back, a target.
  [[nodiscard]] int step() const { return sequence_ > 0 ? script_[sequence_ - 1].step : -1; }
  // Of the steps on the way in [m], from 0; none for a target.
  [[nodiscard]] const std::vector<double>& depths() const { return depths_; }

 private:
  struct Moment {
    Eigen::Vector3d p_S_tip{0, 0, 0};
    int step = -1;
  };
  void ScriptPress(const Scene& scene, const MembraneScript& script);

  StereoSite& site_;
  double rate_;                 // [Hz]
  std::vector<double> depths_;  // [m]
  std::vector<Moment> script_;  // one per pair
  std::uint64_t sequence_ = 0;  // pairs taken
};

}  // namespace palpate
