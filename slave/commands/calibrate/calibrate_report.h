// What `calibrate` has found, for people: tables, sentences and a drawing.
#pragma once

#include <filesystem>
#include <string>
#include <vector>

#include <Eigen/Geometry>

#include "slave/commands/calibrate/calibrate_pictures.h"
#include "slave/vision/calibration/calibration_verdict.h"
#include "slave/vision/calibration/lens_calibration.h"
#include "slave/vision/calibration/registration.h"

namespace palpate {

// One picture or pair.
struct CalibrationRow {
  std::string name;        // of the picture, or of the left one
  std::string right_name;  // pairs only
  bool used = false;
  std::string why_not;                                     // where it is not used
  double left_px = 0;                                      // rms
  double right_px = 0;                                     // pairs only
  double pixel = 0;                                        // on the board [m]
  Eigen::Isometry3d X_LB = Eigen::Isometry3d::Identity();  // of the board
  Corners left, right;                                     // as seen [px]

  [[nodiscard]] std::string full_name() const {
    return right_name.empty() ? name : name + " " + right_name;
  }
};

struct CalibrationReport {
  Board board;
  bool is_pair = false;
  double distance = 0;  // of a plane whose pixel size is asked for [m]; 0: none
  StereoRig rig;
  std::vector<CalibrationRow> rows;
  std::vector<std::string> notes;  // before the verdict
  CalibrationEvidence question;
  CalibrationVerdict verdict;
};

// Size of a pixel on the board [m], as its neighbours lie apart.
double PixelOnBoard(const Corners& corners, const Board& board);

std::string Words(const CalibrationReport& report);
std::string Words(const CameraRegistration& registration);
// Where a camera with z forward stands and looks.
std::string StandingWords(const Eigen::Isometry3d& X_SC);

// Boards and cameras from above, corners over the pictures, residuals. Throws std::runtime_error
// naming the file.
void WriteDrawing(const std::filesystem::path& file, const CalibrationReport& report);

// From the boards in pictures to a lens or a rig, with all that is to be said about it.
// Both throw std::runtime_error in words where the pictures define none; pictures and pairs that
// contradict the others are named in the report's rows and left out.
CalibrationReport CalibrateOneCamera(const Board& board, const BoardPictures& side);
// A rig that can be trusted has the left camera left: exchanged sides are put right, with a note.
CalibrationReport CalibrateTwoCameras(const Board& board, const BoardPictures& left,
                                      const BoardPictures& right);

}  // namespace palpate
