// What is tried: an alteration of a run, how severe it is and what is demanded under it.
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

// Changes of everything between the world and a sense; what is empty changes nothing.
struct Alteration {
  // Into each image, last of all.
  Paint paint;
  // Which sample is shown instead of this moment's; stamps go on.
  std::function<std::size_t(const Moment&)> shows;
  // Where the image is as it was in the first one: `mask` (CV_8U) is to be set there.
  std::function<void(const Moment&, cv::Mat& mask)> stale;
  // How far the object has moved as a whole, in pixels of the image; whole ones are painted
  // without loss. One camera only.
  std::function<Eigen::Vector2d(const Moment&)> object_moves;
  // From when on left becomes right.
  std::optional<When> swapped;
  // What the fingertips read.
  std::function<void(const Moment&, TactileFrame&)> touch;
  // Whether this sample is lost on its way; the run is shorter for the sense.
  std::function<bool(const Moment&)> loses;
  // What the scene states wrongly to the sense.
  std::function<void(Scene&)> tell;
  // Error of the arm's reported tip [px], or [m] without images.
  double arm_error = 0;
};

enum class Demand {
  kRight,  // at least 80 % `valid`, of these 5 % rms of the peak; none silently wrong
  kFlag,   // may be other than `valid` as often as it likes; none silently wrong
};

struct Case {
  std::string name;     // "glint on the shaft, moving"
  double severity = 0;  // in the words of `unit`
  std::string unit;     // "px"; empty: there is no severity
  Demand demand = Demand::kFlag;
  Alteration alteration;
  std::string stage;  // only on the stage of this name; empty: on all of its sense but special ones

  // Whether `--quick` tries it: the harshest severity that must be right, the mildest that may be
  // doubted.
  bool is_quick = true;

  [[nodiscard]] std::string title() const;  // "glint on the shaft, moving: 4 px"
};

// Beforehand, as the suite demands it: from mild to harsh.
std::vector<Case> CameraCases();
std::vector<Case> PairCases();
std::vector<Case> FingertipCases();

// --- Alteration::shows
// Nothing new from `when` on.
std::function<std::size_t(const Moment&)> Frozen(When when);
// Every other image is the one before again.
std::function<std::size_t(const Moment&)> Doubled();
// Every fifth image is one of `samples` before.
std::function<std::size_t(const Moment&)> NowAndThenOld(std::size_t samples);
// Everything `samples` late; `side` < 0: both of a pair.
std::function<std::size_t(const Moment&)> Late(std::size_t samples, int side = -1);

}  // namespace palpate::robustness
