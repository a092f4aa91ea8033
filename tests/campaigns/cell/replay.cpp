#include "tests/campaigns/cell/replay.h"

#include <cstdint>
#include <functional>
#include <memory>
#include <optional>
#include <string>
#include <utility>

#include "shared/state/driven_clock.h"
#include "slave/live/live_slave.h"

namespace palpate::campaign {
namespace {

class AlteredSamples final : public SamplePlayer {
 public:
  AlteredSamples(const std::vector<Altered>& samples, double rate)
      : samples_(samples), rate_(rate) {}

  // The index of the sample given last in its run.
  [[nodiscard]] std::size_t index() const { return samples_[next_ - 1].index; }

  std::unique_ptr<FrameSource> OpenFrames() override {
    return std::make_unique<Source<FrameSource, Frame>>(*this, [this](const Altered& sample) {
      return Frame{sample.left, sample.index + 1, StampOf(sample)};
    });
  }
  std::unique_ptr<StereoSource> OpenPairs() override {
    return std::make_unique<Source<StereoSource, StereoPair>>(*this, [this](const Altered& sample) {
      return StereoPair{sample.left, sample.right, sample.index + 1, StampOf(sample)};
    });
  }
  std::unique_ptr<TactileSource> OpenFingertips() override {
    return std::make_unique<Source<TactileSource, TactileFrame>>(
        *this, [this](const Altered& sample) {
          TactileFrame frame = sample.touch;
          frame.sequence = sample.index + 1;
          frame.sensed_at = StampOf(sample);
          return frame;
        });
  }

 private:
  template <typename Of, typename Sample>
  class Source final : public Of {
   public:
    Source(AlteredSamples& samples, std::function<Sample(const Altered&)> make)
        : samples_(samples), make_(std::move(make)) {}
    std::optional<Sample> Next(const std::stop_token& /*stop*/) override {
      if (samples_.next_ == samples_.samples_.size()) return std::nullopt;
      return make_(samples_.samples_[samples_.next_++]);
    }
    [[nodiscard]] std::string description() const override { return "an altered run"; }

   private:
    AlteredSamples& samples_;
    std::function<Sample(const Altered&)> make_;
  };

  [[nodiscard]] Time StampOf(const Altered& sample) const {
    return Time{} + Seconds(static_cast<double>(sample.index) / rate_);
  }

  const std::vector<Altered>& samples_;
  double rate_;  // [Hz]
  std::size_t next_ = 0;
};

}  // namespace

void Replay(const Run& run, const Scene& stated, const std::vector<Altered>& altered,
            std::size_t rest, double arm_error, const Taker& take) {
  const DrivenClock clock;
  AlteredSamples samples(altered, SensorRate(run.scene.sense));
  auto manipulator = std::make_unique<PlayedManipulator>(stated.manipulator.home);
  PlayedManipulator& encoders = *manipulator;
  const auto slave = MakePlayedSlave(stated, samples, std::move(manipulator));
  const auto offline_report = slave->sense().OpenOfflineReport(nullptr);
  std::optional<std::uint32_t> frame;  // of the encoders; nullopt: there are none
  if (stated.manipulator.source != ManipulatorOptions::Source::kNone) frame = 0;
  const bool of_fingers = run.scene.sense.Find<Tactile>() != nullptr;
  while (slave->Acquire({})) {
    const Truth& truth = run.shots[samples.index()].truth;
    encoders.Play(truth.p_S_tip + Eigen::Vector3d(0, arm_error, 0), frame);
    slave->Estimate();
    const std::vector<StateRow> rows = offline_report->Add({}, nullptr);
    if (samples.index() < rest) continue;
    for (std::size_t i = 0; i < rows.size(); ++i) {
      take(samples.index(), rows[i], of_fingers ? truth.fingers[i].force : truth.force);
    }
  }
}

}  // namespace palpate::campaign
