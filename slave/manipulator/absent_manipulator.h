// No manipulator: a person holds the tool, or another controller moves it.
#pragma once

#include "slave/manipulator/manipulator.h"

namespace palpate {

// Its tip stays at home. No check uses it.
class AbsentManipulator final : public Manipulator {
 public:
  explicit AbsentManipulator(const ManipulatorOptions& options) : home_(options.home) {}

  bool Command(const Eigen::Vector3d& /*p_S_target*/) noexcept override { return false; }
  void Hold() noexcept override {}
  [[nodiscard]] Eigen::Vector3d Tip() const noexcept override { return home_; }
  [[nodiscard]] bool at_limit() const noexcept override { return false; }
  [[nodiscard]] bool carries_tool() const noexcept override { return false; }

 private:
  const Eigen::Vector3d home_;  // S [m]
};

}  // namespace palpate
