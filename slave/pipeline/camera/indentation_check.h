// Does the dent that the object's edge shows agree with the dent that the model computes for the
// tip, and is the picture one to believe at all?
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

// One thread; allocation-free once the first dent was expected.
class IndentationCheck {
 public:
  // Sigma of the tip from which on it is only roughly known [px].
  static constexpr double kRoughTip = 0.4;

  // What is to be judged: a force told for a tip, once its contact is known.
  struct Prediction {
    Eigen::Vector2d dent_O{0, 0};  // displacement of the contact's patch as the tip tells it [px]
    double sigma_px = 0;           // of the tip, with that of the picture's motion
    double covered = 0;            // part of the tip's template [-]
  };

  // Tells the watch how the outline moves with the patch at `place`, while the tool is there or
  // comes near. A round tool's dent changes its shape as it deepens.
  void Expect(const BoundaryPlace& place, const ObjectRegistrationMonitor::Bar& tool,
              const Eigen::Isometry3d& X_SO, const CameraView& view, TouchModel* touch,
              ObjectRegistrationMonitor* watch) noexcept;
  [[nodiscard]] bool expects() const noexcept { return element_ >= 0; }
  // Of a dent as the model tells it, relative [-].
  [[nodiscard]] double sigma() const noexcept { return sigma_; }

  // Doubts the force just told where the object's edge says otherwise.
  void Check(const Prediction& prediction, const ObjectSighting& seen,
             ContactEstimate* felt) noexcept;

  // Another model answers from now on.
  void Adopt() noexcept { element_ = -1; }
  void Reset() noexcept { distrust_ = unconfirmed_ = 0; }

 private:
  bool Take(const BoundaryPlace& place, double depth, TouchModel* touch) noexcept;
  [[nodiscard]] bool Agrees(const Prediction& prediction,
                            const ObjectSighting& seen) const noexcept;

  int element_ = -1;  // whose dent the watch knows; -1: none
  double sigma_ = 0;
  double depth_ = 0;  // at which a round tool's was taken [m]
  std::vector<Eigen::Vector3d> along_n_, along_t_, along_x_, along_y_;
  int unconfirmed_ = 0;  // pictures since the dent was seen last
  int distrust_ = 0;     // pictures until a dent is believed again
};

}  // namespace palpate
