// A shipped scene with a press that is simulated once: its samples and the true state at each.
// Every case plays them again with alterations.
#pragma once

#include <functional>
#include <memory>
#include <string>
#include <vector>

#include "slave/capture/frame_source.h"
#include "slave/capture/tactile_frame.h"
#include "slave/scene/scene.h"
#include "slave/simulator/environment/simulated_environment.h"
#include "tests/campaigns/robustness/case.h"
#include "tests/campaigns/robustness/moment.h"

namespace palpate::robustness {

struct Shot {
  cv::Mat left, right;  // images; one camera uses `left` only
  TactileFrame touch;
  Truth truth;
};

// Number of samples: a few dozen of a fast press, or all of a press at the scene's speed.
enum class Extent { kQuick, kFull };

class Stage {
 public:
  virtual ~Stage() = default;
  Stage(const Stage&) = delete;
  Stage& operator=(const Stage&) = delete;

  [[nodiscard]] const std::string& name() const { return name_; }
  // `camera`, `pairs`, `fingertips`.
  [[nodiscard]] const std::string& sense() const { return sense_; }
  [[nodiscard]] const Scene& scene() const { return scene_; }
  [[nodiscard]] const Script& script() const { return script_; }
  [[nodiscard]] double rate() const { return rate_; }  // of the samples [Hz]
  [[nodiscard]] double peak() const { return peak_; }  // the largest true force [N]

  // Edge of a pixel where the tool is [m]; 1: no images.
  [[nodiscard]] virtual double pixel() const { return 1; }

  // The run as it is; while the object moves too, if it does.
  [[nodiscard]] const std::vector<Shot>& shots() const { return shots_; }
  [[nodiscard]] virtual std::vector<Shot> Moving(
      const std::function<Eigen::Vector2d(const Moment&)>& moves) {
    static_cast<void>(moves);
    return shots_;
  }
  [[nodiscard]] virtual View ViewOf(const Moment& moment) const = 0;

 protected:
  Stage(std::string name, std::string sense, Scene scene);
  // From here on `shots` are the run.
  void Keep(std::vector<Shot> shots);

  Script script_;

 private:
  std::string name_, sense_;
  Scene scene_;
  double rate_, peak_ = 0;
  std::vector<Shot> shots_;
};

// Makes a stage on request; its name (such as `silicone-block`) is known without computing it.
struct StageMaker {
  std::string name, sense;
  std::function<std::unique_ptr<Stage>(Extent)> make;
  bool is_special = false;  // only for cases that name it

  [[nodiscard]] bool Suits(const Case& tried) const {
    return tried.stage.empty() ? !is_special : tried.stage == name;
  }
};
// Stages of shipped scenes and of scenes derived from them: all, or those of `--quick`.
std::vector<StageMaker> StagesOf(Extent extent);

}  // namespace palpate::robustness
