// A manipulator whose readings are played with the samples of a recording or a script.
#pragma once

#include <cstdint>
#include <optional>

#include "slave/manipulator/manipulator.h"

namespace palpate {

// Ignores commands and reports the recorded positions. For one thread.
class PlayedManipulator final : public Manipulator {
 public:
  explicit PlayedManipulator(const Eigen::Vector3d& p_S_home) : p_S_tip_(p_S_home) {}

  // The encoders' reading at the next estimate, S [m], and the number of their origin; nullopt: the
  // sample is not compared with them.
  void Play(const Eigen::Vector3d& p_S_tip, std::optional<std::uint32_t> frame) {
    p_S_tip_ = p_S_tip;
    frame_ = frame;
  }

  bool Command(const Eigen::Vector3d& /*p_S_target*/) noexcept override { return false; }
  void Hold() noexcept override {}
  [[nodiscard]] Eigen::Vector3d Tip() const noexcept override { return p_S_tip_; }
  [[nodiscard]] std::uint32_t frame() const noexcept override { return frame_.value_or(0); }
  [[nodiscard]] bool at_limit() const noexcept override { return false; }
  [[nodiscard]] bool carries_tool() const noexcept override { return true; }
  [[nodiscard]] bool comes_with_samples() const noexcept override { return true; }
  [[nodiscard]] bool is_faulty() const noexcept override { return !frame_; }

 private:
  Eigen::Vector3d p_S_tip_;             // [m]
  std::optional<std::uint32_t> frame_;  // nullopt: no reading to compare with
};

}  // namespace palpate
