// From the boards in pictures to a lens or a rig, with all that is to be said about it.
#pragma once

#include "slave/commands/calibrate/calibrate_pictures.h"
#include "slave/commands/calibrate/calibrate_report.h"

namespace palpate {

// Both throw std::runtime_error in words where the pictures define none; pictures and pairs that
// contradict the others are named in the report's rows and left out.
CalibrationReport CalibrateOneCamera(const Board& board, const BoardPictures& side);
// A rig that can be trusted has the left camera left: exchanged sides are put right, with a note.
CalibrationReport CalibrateTwoCameras(const Board& board, const BoardPictures& left,
                                      const BoardPictures& right);

}  // namespace palpate
