// What the tetrahedra of a zone resist beyond Hooke's law, r, as the linear body takes it over: at
// all nodes, accelerated, or at the few where that changes the contact's force most. Between two
// states it is extrapolated, and with it the displacement that it causes. Nondimensional.
#pragma once

#include <utility>
#include <vector>

#include <Eigen/Core>

#include "slave/mechanics/fem/zone/fixed_point_mixer.h"

namespace palpate {

class ZoneLoads {
 public:
  // For so many numbers; `green`: displacements of the nodes by forces on them.
  ZoneLoads(int size, Eigen::MatrixXf green);

  [[nodiscard]] const Eigen::MatrixXf& green() const { return green_; }
  // At the present displacement, set by the caller; as taken over; G times that.
  [[nodiscard]] Eigen::VectorXd& r() { return r_; }
  [[nodiscard]] const Eigen::VectorXd& taken() const { return taken_; }
  [[nodiscard]] const Eigen::VectorXf& moved() const { return moved_; }

  // None of these allocates.
  void Reset() noexcept;
  // A new state begins, by a share of the last change further on.
  void Begin(double share) noexcept;
  // Takes r over. `dual`: displacement by unit motions of the contact; `force`: its size.
  void TakeAll() noexcept;
  void TakeMostChanged(const Eigen::MatrixXd& dual, double force) noexcept;
  // From r as taken elsewhere.
  void SetTaken(const Eigen::VectorXd& taken) noexcept;

 private:
  Eigen::MatrixXf green_;
  FixedPointMixer mixer_;
  Eigen::VectorXd r_, taken_, next_;  // the latter: to be taken
  Eigen::VectorXf moved_, load_;
  struct {
    Eigen::VectorXd r, taken;
    Eigen::VectorXf moved;
  } before_;            // at the state before
  bool begins_ = true;  // nothing was taken in this state
  int few_ = 0;         // times since all of r was taken
  std::vector<std::pair<double, int>> changed_;
  std::vector<int> places_;
};

}  // namespace palpate
