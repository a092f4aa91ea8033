// The part of `calibrate` that fits a lens or a rig to the boards in the images.
#pragma once

#include <string>
#include <vector>

#include "slave/commands/calibrate/board_images.h"
#include "slave/vision/calibration/calibration.h"

namespace palpate {

struct CalibrationReport {
  Calibration calibration;
  struct Row {
    std::string name;     // of the image or the pair
    std::string why_not;  // the reason why it is not used; empty: it is used
    std::string rms_px;   // of the left and the right image
  };
  std::vector<Row> rows;
  std::vector<std::string> notes;
};

// Both throw std::runtime_error with a sentence if the images determine no lens or rig. Images and
// pairs that contradict the others are listed in the report's rows and not used.
CalibrationReport CalibrateOneCamera(const Board& board, const DetectedBoards& side);
// In an accepted rig the left camera is on the left: exchanged sides are corrected, with a note.
CalibrationReport CalibrateTwoCameras(const Board& board, const DetectedBoards& left,
                                      const DetectedBoards& right);

// The report as a table and sentences.
std::string Words(const CalibrationReport& report);

}  // namespace palpate
