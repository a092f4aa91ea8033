// The membrane of a scene as it really is, and the tool on it.
#pragma once

#include <memory>
#include <mutex>

#include <Eigen/Core>
#include <Eigen/Geometry>

#include "slave/reference/membrane/pressed_membrane.h"
#include "slave/scene/scene.h"
#include "slave/simulator/environment/simulated_environment.h"
#include "slave/simulator/points/press_cache.h"

namespace palpate::simulation {

class TrueMembrane {
 public:
  struct Now {
    Eigen::Vector3d p_S_tip{0, 0, 0};
    bool in_contact = false;
    bool solved = true;  // as in Truth
    Indentation indentation;
  };

  // Throws std::invalid_argument naming the key: no membrane, no tool, scenes that PressedMembrane
  // rejects.
  TrueMembrane(const Scene& scene, const MembraneResolution& resolution);

  // See StereoSite. Thread-safe.
  void MoveTool(const Eigen::Vector3d& p_S_tip, WhenUnsolved when_unsolved);
  void SolveEverywhere() { presses_.SolveEverywhere(); }
  [[nodiscard]] Now now() const;
  [[nodiscard]] const Eigen::Isometry3d& X_SO() const { return X_SO_; }  // misplacement included

 private:
  void Move(const Eigen::Vector3d& p_S_tip, WhenUnsolved when_unsolved);

  Eigen::Isometry3d X_SO_;
  double rim_;  // [m]

  std::mutex moving_;  // one mover at a time

  mutable std::mutex mutex_;  // guards the members that other threads read
  Now now_;

  PressCache presses_;
};

}  // namespace palpate::simulation
