// CameraSample is the input of the checks of one camera for one image.
#pragma once

#include <optional>

#include <Eigen/Core>
#include <opencv2/core/mat.hpp>

#include "slave/checks/camera/camera_limits.h"
#include "slave/vision/object_sighting.h"
#include "slave/vision/observation.h"

namespace palpate {

// Measured minus predicted tip, of the encoders' registration [px], and sigma per axis [px].
struct EncoderInnovation {
  Eigen::Vector2d value{0, 0};
  double sigma = 0;
};

struct CameraSample {
  const cv::Mat& image;
  const TipObservation& tip;
  const ObjectSighting* object = nullptr;    // null: the scene tracks no contour
  std::optional<EncoderInnovation> encoder;  // nullopt: the encoders do not report this tool
  bool is_broken = false;                    // the membrane is punctured
  // Whether the model has an answer for a tool that may indent the object, so that the edge can be
  // compared with it.
  bool is_solved = false;
  Eigen::Vector2d indentation_O{0, 0};  // displacement of the contact according to the tip [px]
  Eigen::Vector2d normal_O{0, 0};       // outward unit normal there [-]
  double indentation_sigma = 0;         // error of the model's indentation, relative [-]
  double tip_sigma = 0;                 // including the compensated image motion [px]
  // Sigma of errors that are equal in all images of a contact: position of the tool's end in its
  // template, position of the surface, and a tilted end face [px].
  double place_sigma = 0;

  // The object's edge can be compared with the model.
  [[nodiscard]] bool compares_edge() const { return object && is_solved && !is_broken; }
};

}  // namespace palpate
