// A test case: an alteration of a run, its severity and the required result.
#pragma once

#include <cstddef>
#include <functional>
#include <optional>
#include <string>
#include <vector>

#include <Eigen/Core>

#include "slave/capture/tactile_frame.h"
#include "slave/scene/scene.h"
#include "tests/campaigns/robustness/moment.h"
#include "tests/campaigns/robustness/paint.h"

namespace palpate::robustness {

// Functions that change what lies between the world and a sense. An empty function changes nothing.
struct Alteration {
  // Into each image, last of all.
  Paint paint;
  // Returns the index of the sample that is shown instead of the current one. Timestamps are
  // unchanged.
  std::function<std::size_t(const Moment&)> shows;
  // Sets `mask` (CV_8U) where the image keeps the content of the first image.
  std::function<void(const Moment&, cv::Mat& mask)> stale;
  // Rigid displacement of the object in the image [px]; integers need no interpolation. For one
  // camera only.
  std::function<Eigen::Vector2d(const Moment&)> object_moves;
  // Time from which left and right are exchanged.
  std::optional<When> swapped;
  // Changes the readings of the fingertips.
  std::function<void(const Moment&, TactileFrame&)> touch;
  // Returns whether this sample is lost on the link; the sense then receives fewer samples.
  std::function<bool(const Moment&)> loses;
  // Changes the scene that the sense gets, so that it contains wrong statements.
  std::function<void(Scene&)> tell;
  // Error of the arm's reported tip [px], or [m] without images.
  double arm_error = 0;
};

enum class Demand {
  // At least 80 % of the forces `valid` with an rms error of 5 % of the peak; no undetected error.
  kRight,
  kFlag,  // any number of forces may be flagged; no undetected error
};

struct Case {
  std::string name;     // "glint on the shaft, moving"
  double severity = 0;  // in the words of `unit`
  std::string unit;     // "px"; empty: there is no severity
  Demand demand = Demand::kFlag;
  Alteration alteration;
  std::string stage;  // only on the stage of this name; empty: on all of its sense but special ones

  // Whether `--quick` runs this case: the highest severity of kRight and the lowest of kFlag.
  bool is_quick = true;

  [[nodiscard]] std::string title() const;  // "glint on the shaft, moving: 4 px"
};

// Beforehand, as the suite demands it: from mild to harsh.
std::vector<Case> CameraCases();
std::vector<Case> PairCases();
std::vector<Case> FingertipCases();

// --- Alteration::shows Repeats the last sample from `when` on.
std::function<std::size_t(const Moment&)> Frozen(When when);
// Every other image is the one before again.
std::function<std::size_t(const Moment&)> Doubled();
// Every fifth image is one of `samples` before.
std::function<std::size_t(const Moment&)> NowAndThenOld(std::size_t samples);
// Everything `samples` late; `side` < 0: both of a pair.
std::function<std::size_t(const Moment&)> Late(std::size_t samples, int side = -1);

}  // namespace palpate::robustness
