// Decides whether a calibration is accepted: a small residual shows that the numbers fit these
// images, not that other images would give the same ones.
#pragma once

#include <array>
#include <string>
#include <vector>

#include "slave/vision/calibration/pair_calibration.h"

namespace palpate {

// A quantity estimated from each half of the images alone: first odd and even ones, then random
// halves (fixed seed). Images with nearly the same pose of the board are not independent: they
// count as one and go to the same half.
struct HalvesCheck {
  double odd_even = 0;         // |a - b|, relative to the estimate from all
  std::vector<double> random;  // the same for 20 random halves, sorted
  int failed = 0;              // number of halves without an estimate
  std::size_t distinct = 0;    // number of different images or pairs
  // One standard deviation of the estimate from all: a half has twice its variance, the difference
  // of two halves four times.
  [[nodiscard]] double sigma() const;
  [[nodiscard]] double worst() const;
};
constexpr int kRandomHalves = 20;
constexpr std::size_t kFewestForHalves = 4;  // number of different images or pairs

// Error of the baseline. Pairs as used for `rig`, from which the halves are refined.
HalvesCheck CheckHalves(const Board& board, const std::vector<PairView>& pairs,
                        const StereoRig& rig);
// Error of the focal length.
HalvesCheck CheckHalves(const Board& board, const std::vector<Corners>& views,
                        const std::array<int, 2>& size, double focal);

// Share of the 8 x 6 cells of the image in which a corner was detected.
double CoverageOf(const std::vector<Corners>& views, const std::array<int, 2>& size);

struct CalibrationVerdict {
  std::vector<std::string> reasons;   // why not; empty: it may be trusted
  std::vector<std::string> warnings;  // weak points that do not cause a rejection
};

struct CalibrationEvidence {
  const char* quantity = "baseline";  // quantity estimated from the halves, as text
  const char* things = "pairs";       // kind of samples, as text
  std::size_t used = 0, given = 0;    // of them, with a board
  double rms_px = 0;
  double sigma_focal = 0;  // relative
  HalvesCheck halves;
  std::vector<double> coverage;  // of each camera
};
CalibrationVerdict EvaluateCalibration(const CalibrationEvidence& question);

// The camera given as the right one is to the left of the other.
bool AreSidesExchanged(const StereoRig& rig);
// The same pair with left and right exchanged.
StereoRig Exchanged(const StereoRig& rig);

}  // namespace palpate
