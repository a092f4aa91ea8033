// What the checks of one camera get of one image.
#pragma once

#include <Eigen/Core>
#include <opencv2/core/mat.hpp>

#include "slave/checks/camera/camera_limits.h"
#include "slave/vision/object_sighting.h"
#include "slave/vision/observation.h"

namespace palpate {

struct CameraSample {
  const cv::Mat& image;
  const TipObservation& tip;
  const ObjectSighting* object = nullptr;  // null: the scene tracks no contour
  bool agrees_with_encoders = true;        // also if the encoders do not report this tool
  bool is_broken = false;                  // the membrane is punctured
  // The model has an answer for a tool that may dent the object: the edge can be compared with it.
  bool is_solved = false;
  Eigen::Vector2d dent_O{0, 0};  // displacement of the contact according to the tip [px]
  double dent_sigma = 0;         // error of the model's indentation, relative [-]
  double tip_sigma = 0;          // including the compensated image motion [px]

  // The object's edge can be compared with the model.
  [[nodiscard]] bool compares_edge() const { return object && is_solved && !is_broken; }
  // The edge beside the tool shows the indentation, or it is too small to be seen.
  [[nodiscard]] bool is_dent_confirmed() const {
    return object->dent_known || dent_O.norm() < CameraLimits::kSmallDent;
  }
};

}  // namespace palpate
