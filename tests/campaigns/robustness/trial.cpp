#include "tests/campaigns/robustness/trial.h"

#include <algorithm>
#include <cmath>
#include <functional>
#include <map>
#include <memory>
#include <optional>
#include <stdexcept>
#include <string>
#include <utility>
#include <vector>

#include "shared/state/driven_clock.h"
#include "shared/wire/enum_names.h"
#include "slave/live/live_slave.h"
#include "slave/pipeline/offline/offline_report.h"

namespace palpate::robustness {
namespace {

constexpr double kContactShare = 0.01;  // of the largest true force

// The samples of a stage with alterations, and the true state at each.
class AlteredSamples final : public SamplePlayer {
 public:
  AlteredSamples(Stage& stage, const Alteration& alteration)
      : stage_(stage),
        alteration_(alteration),
        shots_(alteration.object_moves ? stage.Moving(alteration.object_moves) : stage.shots()) {}

  // The true state at the last sample.
  [[nodiscard]] Truth truth() const {
    Truth truth = shots_[index_].truth;
    truth.p_S_tip.y() += alteration_.arm_error * stage_.pixel();
    return truth;
  }
  [[nodiscard]] std::size_t index() const { return index_; }  // of the sample given last

  std::unique_ptr<FrameSource> OpenFrames() override {
    return std::make_unique<Source<FrameSource, Frame>>(*this, [this] {
      return Frame{Image(0), next_, StampOf(index_)};
    });
  }
  std::unique_ptr<StereoSource> OpenPairs() override {
    return std::make_unique<Source<StereoSource, StereoPair>>(*this, [this] {
      StereoPair pair{Image(0), Image(1), next_, StampOf(index_)};
      const Moment moment{stage_.script(), index_};
      const bool swapped = alteration_.swapped && IsSo(*alteration_.swapped, moment);
      if (swapped) std::swap(pair.left, pair.right);
      return pair;
    });
  }
  std::unique_ptr<TactileSource> OpenFingertips() override {
    return std::make_unique<Source<TactileSource, TactileFrame>>(*this, [this] {
      const Moment moment{stage_.script(), index_};
      TactileFrame frame = shots_[ShownAt(moment)].touch;
      frame.sequence = next_;
      frame.sensed_at = StampOf(index_);
      if (alteration_.touch) alteration_.touch(moment, frame);
      return frame;
    });
  }

 private:
  template <typename Of, typename Sample>
  class Source final : public Of {
   public:
    Source(AlteredSamples& samples, std::function<Sample()> take)
        : samples_(samples), take_(std::move(take)) {}
    std::optional<Sample> Next(const std::stop_token& /*stop*/) override {
      if (!samples_.Advance()) return std::nullopt;
      return take_();
    }
    [[nodiscard]] std::string description() const override { return "an altered run"; }

   private:
    AlteredSamples& samples_;
    std::function<Sample()> take_;
  };

  bool Advance() {
    const auto lost = [&] {
      return alteration_.loses && alteration_.loses({stage_.script(), next_});
    };
    while (next_ < shots_.size() && lost()) ++next_;
    if (next_ == shots_.size()) return false;
    index_ = next_++;
    return true;
  }
  [[nodiscard]] Time StampOf(std::size_t index) const {
    return Time{} + Seconds(static_cast<double>(index) / stage_.rate());
  }
  [[nodiscard]] std::size_t ShownAt(const Moment& moment) const {
    return alteration_.shows ? alteration_.shows(moment) : moment.index;
  }
  [[nodiscard]] cv::Mat Image(int side) const {
    const Moment moment{stage_.script(), index_, side};
    const Moment shown{moment.script, ShownAt(moment), side};
    const Shot& shot = shots_[shown.index];
    cv::Mat image = (side == 0 ? shot.left : shot.right).clone();
    if (alteration_.stale && !image.empty()) {
      cv::Mat mask(image.size(), CV_8U, cv::Scalar(0));
      alteration_.stale(shown, mask);
      (side == 0 ? shots_.front().left : shots_.front().right).copyTo(image, mask);
    }
    if (alteration_.paint && !image.empty()) alteration_.paint(stage_.ViewOf(shown), image);
    return image;
  }

  Stage& stage_;
  const Alteration& alteration_;
  std::vector<Shot> shots_;
  std::size_t index_ = 0, next_ = 0;
};

// Compares the rows with the truth.
class Tally {
 public:
  // `peak`: the largest true force [N].
  explicit Tally(double peak) : peak_(peak) {}

  void Add(const StateRow& row, const Eigen::Vector3d& truth) {
    ++score_.samples;
    if (row.validity != Validity::kValid) {
      const bool is_named = row.check != FailedCheck::kNone;
      ++reasons_[std::string(is_named ? ToString(row.check) : ToString(row.validity))];
      return;
    }
    ++score_.valid;
    const Eigen::Vector3d force = row.force.value_or(kUnknownVector);
    const double error = (force - truth).norm() / peak_, sigma = row.sigma / peak_;
    // This comparison also rejects NaN.
    if (!(error <= kSilentShare || error <= kSilentSigmas * sigma)) ++score_.silent;
    if (std::max(force.norm(), truth.norm()) <= kContactShare * peak_) return;
    squares_ += error * error;
    score_.worst = std::max(score_.worst, error);
    if (sigma > 0) ratios_ += error * error / (sigma * sigma);
    sigmas_.push_back(sigma);
  }

  Score Finish() {
    if (!sigmas_.empty()) {
      score_.touching = sigmas_.size();
      const auto count = static_cast<double>(sigmas_.size());
      score_.rms = std::sqrt(squares_ / count);
      score_.z = std::sqrt(ratios_ / count);
      std::ranges::nth_element(sigmas_, sigmas_.begin() + std::ssize(sigmas_) / 2);
      score_.sigma = sigmas_[sigmas_.size() / 2];
    }
    const auto most =
        std::ranges::max_element(reasons_, {}, [](const auto& reason) { return reason.second; });
    if (most != reasons_.end()) score_.why = most->first;
    return score_;
  }

 private:
  double peak_;
  Score score_;
  double squares_ = 0, ratios_ = 0;
  std::vector<double> sigmas_;
  std::map<std::string, std::size_t> reasons_;
};

}  // namespace

void Replay(Stage& stage, const Alteration& alteration, const Taker& take) {
  Scene stated = stage.scene();
  if (alteration.tell) alteration.tell(stated);
  const DrivenClock clock;
  AlteredSamples samples(stage, alteration);
  auto manipulator = std::make_unique<PlayedManipulator>(stated.manipulator.home);
  PlayedManipulator& encoders = *manipulator;
  const auto slave = MakePlayedSlave(stated, samples, std::move(manipulator));
  const auto offline_report = slave->sense().OpenOfflineReport(nullptr);
  std::optional<std::uint32_t> frame;  // of the encoders; nullopt: there are none
  if (stated.manipulator.source != ManipulatorOptions::Source::kNone) frame = 0;
  while (slave->Acquire({})) {
    const Truth truth = samples.truth();
    encoders.Play(truth.p_S_tip, frame);
    slave->Estimate();
    const std::vector<StateRow> rows = offline_report->Add({}, nullptr);
    if (samples.index() < stage.script().way) continue;
    for (std::size_t i = 0; i < rows.size(); ++i) {
      const bool of_finger = stage.sense() == "fingertips";
      const Eigen::Vector3d& force = of_finger ? truth.fingers[i].force : truth.force;
      take(samples.index(), rows[i], force);
    }
  }
}

bool Score::Holds(Demand demand) const {
  if (silent > 0) return false;
  const double share =
      static_cast<double>(valid) / static_cast<double>(std::max<std::size_t>(samples, 1));
  return demand == Demand::kFlag || (rms <= kRightRms && share >= kRightValid && samples > 0);
}

Score Try(Stage& stage, const Case& tried) {
  Tally tally(stage.peak());
  std::string refused;
  try {
    Replay(stage, tried.alteration,
           [&](std::size_t, const StateRow& row, const auto& truth) { tally.Add(row, truth); });
    // The sense refuses with a message; any other exception is a defect.
  } catch (const std::runtime_error& why) {
    refused = why.what();
  } catch (const std::invalid_argument& why) {
    refused = why.what();
  }
  Score score = tally.Finish();
  if (!refused.empty()) score.why = "refused: " + refused;
  return score;
}

}  // namespace palpate::robustness
