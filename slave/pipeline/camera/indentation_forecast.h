// Computes how the object's edge moves with the contact, so that the monitor can find it.
#pragma once

#include <vector>

#include <Eigen/Core>
#include <Eigen/Geometry>

#include "slave/contact/boundary_contact.h"
#include "slave/pipeline/camera/object_registration_monitor.h"
#include "slave/pipeline/camera/touch_model.h"
#include "slave/vision/observation.h"

namespace palpate {

// Used by one thread. Allocation-free after the first expected indentation.
class IndentationForecast {
 public:
  // Passes to the monitor the expected motion of the outline per motion of the contact at `place`,
  // while the tool is at or near the surface. The indentation of a round tool changes its shape
  // with depth.
  void Expect(const BoundaryPlace& place, const ObjectRegistrationMonitor::Bar& tool,
              const Eigen::Isometry3d& X_SO, const CameraView& view, TouchModel* touch,
              ObjectRegistrationMonitor* watch) noexcept;
  [[nodiscard]] bool expects() const noexcept { return element_ >= 0; }
  // Error of the model's indentation, relative [-].
  [[nodiscard]] double sigma() const noexcept { return sigma_; }

  // Uses another model from now on.
  void Adopt() noexcept { element_ = -1; }

 private:
  bool Take(const BoundaryPlace& place, double depth, TouchModel* touch) noexcept;

  int element_ = -1;  // element whose indentation the monitor uses; -1: none
  double sigma_ = 0;
  double depth_ = 0;  // at which a round tool's was taken [m]
  std::vector<Eigen::Vector3d> along_n_, along_t_, along_x_, along_y_;
};

}  // namespace palpate
