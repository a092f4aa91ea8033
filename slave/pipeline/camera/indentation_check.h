// Compares the indentation of the object's edge with the one that the model computes for the tip,
// and checks the image quality.
#pragma once

#include <vector>

#include <Eigen/Core>
#include <Eigen/Geometry>

#include "slave/contact/boundary_contact.h"
#include "slave/pipeline/camera/object_registration_monitor.h"
#include "slave/pipeline/camera/touch_model.h"
#include "slave/pipeline/estimate_builder.h"
#include "slave/vision/observation.h"

namespace palpate {

// One thread; allocation-free after the first expected indentation.
class IndentationCheck {
 public:
  // Sigma of the tip from which on it is only roughly known [px].
  static constexpr double kRoughTip = 0.4;

  // Input of the check: an estimate with its contact.
  struct Prediction {
    Eigen::Vector2d dent_O{0, 0};  // displacement of the contact according to the tip [px]
    double sigma_px = 0;           // of the tip, including that of the image motion
    double covered = 0;            // part of the tip's template [-]
  };

  // Gives the monitor the expected motion of the outline per motion of the contact at `place`,
  // while the tool is there or comes near. The indentation of a round tool changes its shape with
  // depth.
  void Expect(const BoundaryPlace& place, const ObjectRegistrationMonitor::Bar& tool,
              const Eigen::Isometry3d& X_SO, const CameraView& view, TouchModel* touch,
              ObjectRegistrationMonitor* watch) noexcept;
  [[nodiscard]] bool expects() const noexcept { return element_ >= 0; }
  // Error of the model's indentation, relative [-].
  [[nodiscard]] double sigma() const noexcept { return sigma_; }

  // Flags the estimate if the object's edge contradicts it.
  void Check(const Prediction& prediction, const ObjectSighting& seen,
             ContactEstimate* felt) noexcept;

  // Uses another model from now on.
  void Adopt() noexcept { element_ = -1; }
  void Reset() noexcept { distrust_ = unconfirmed_ = 0; }

 private:
  bool Take(const BoundaryPlace& place, double depth, TouchModel* touch) noexcept;
  [[nodiscard]] bool Agrees(const Prediction& prediction,
                            const ObjectSighting& seen) const noexcept;

  int element_ = -1;  // element whose indentation the monitor uses; -1: none
  double sigma_ = 0;
  double depth_ = 0;  // at which a round tool's was taken [m]
  std::vector<Eigen::Vector3d> along_n_, along_t_, along_x_, along_y_;
  int unconfirmed_ = 0;  // images since the indentation was last detected
  int distrust_ = 0;     // images until an indentation is trusted again
};

}  // namespace palpate
