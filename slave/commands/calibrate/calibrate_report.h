// The results of `calibrate` for people: tables and sentences.
#pragma once

#include <string>
#include <vector>

#include <Eigen/Geometry>

#include "slave/commands/calibrate/calibrate_pictures.h"
#include "slave/vision/calibration/calibration_verdict.h"
#include "slave/vision/calibration/lens_calibration.h"
#include "slave/vision/calibration/registration.h"

namespace palpate {

// One image or pair.
struct CalibrationRow {
  std::string name;        // residual of the image, or of the left image
  std::string right_name;  // pairs only
  bool used = false;
  std::string why_not;                                     // where it is not used
  double left_px = 0;                                      // rms
  double right_px = 0;                                     // pairs only
  double pixel = 0;                                        // on the board, in the left image [m]
  double right_pixel = 0;                                  // pairs only [m]
  Eigen::Isometry3d X_LB = Eigen::Isometry3d::Identity();  // of the board

  [[nodiscard]] std::string full_name() const {
    return right_name.empty() ? name : name + " " + right_name;
  }
};

struct CalibrationReport {
  Board board;
  bool is_pair = false;
  double distance = 0;  // distance of a plane whose pixel size is printed [m]; 0: none
  StereoRig rig;
  std::vector<CalibrationRow> rows;
  std::vector<std::string> notes;  // before the verdict
  CalibrationEvidence question;
  CalibrationVerdict verdict;
};

std::string Words(const CalibrationReport& report);
std::string Words(const CameraRegistration& registration);
// Position and viewing direction of a camera with z forward.
std::string StandingWords(const Eigen::Isometry3d& X_SC);

// Fits a lens or a rig to the boards in the images and fills the report. Both throw
// std::runtime_error with a sentence if the images determine none. Images and pairs that contradict
// the others are listed in the report's rows and not used.
CalibrationReport CalibrateOneCamera(const Board& board, const BoardPictures& side);
// In an accepted rig the left camera is on the left: exchanged sides are corrected, with a note.
CalibrationReport CalibrateTwoCameras(const Board& board, const BoardPictures& left,
                                      const BoardPictures& right);

}  // namespace palpate
