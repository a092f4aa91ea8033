#include "slave/tactile/training/force_trainer.h"

#include <cmath>
#include <stdexcept>
#include <vector>

#include <gtest/gtest.h>

#include "slave/site/fingertips/simulated_presses.h"
#include "slave/tactile/training/estimate_errors.h"
#include "tests/slave/tactile/training/synthetic_recordings.h"
#include "tests/support/stop_after.h"

namespace palpate {
namespace {

using Descent = ForceTrainingOptions::Descent;

class Quiet final : public Progress {};

class TrainForceTest : public ::testing::Test {
 protected:
  TrainForceTest() {
    for (std::uint32_t i = 0; i < 6; ++i)
      recordings_.push_back(testing::SyntheticRecording(8, i, 30));
    split_ = SplitContacts(recordings_, false, 1);
  }
  [[nodiscard]] ForceErrors Test(const LearntForce& learnt) const {
    const std::vector<Window> windows = WindowsOf(split_.test, kNetworkWindow);
    const auto network = MakeForceNetwork(learnt.info, learnt.weights);
    return CompareForces(EstimateForces(*network, recordings_, windows),
                         MeasuredForces(recordings_, windows));
  }
  LearntForce Train(const ForceTrainingOptions& options) {
    Quiet progress;
    return TrainForce(recordings_, split_, options, progress);
  }

  std::vector<LabelledRecording> recordings_;
  Split split_;
};

// The force is a tenth to an eightieth of electrode counts with noise of one count: 8 to 13 mN,
// beside forces of 150 mN rms at least, so 0.01 is what can be reached. Feed-forward networks see
// one sample, recurrent ones may average.
TEST_F(TrainForceTest, LearnsAForceThatFollowsTheElectrodes) {
  for (const char* architecture : {"dnn_19", "dnn_21", "rnn_19", "rnn_21"}) {
    ForceTrainingOptions options;
    options.architecture = architecture;
    options.epochs = 6;
    const LearntForce learnt = Train(options);
    const ForceErrors errors = Test(learnt);
    EXPECT_LT(errors.smse.maxCoeff(), 0.05) << architecture << "\n" << errors.smse.transpose();
    EXPECT_EQ(learnt.info.architecture, architecture);
    EXPECT_GT(learnt.info.learnt_force, 0.8);
    EXPECT_LT(learnt.info.learnt_force, 1.2);
    EXPECT_EQ(learnt.epochs.size(), 6U);
  }
}

// Electrodes that go together, as a fingertip's do: one in two recordings is taken from the others.
// A moment's training of a few presses; 1 is what no signal at all would do.
TEST_F(TrainForceTest, TracesLearnFromSignalsThatGoTogether) {
  SimulatedPresses presses;
  presses.presses = 60;
  recordings_ = SimulatePresses(presses);
  split_ = SplitContacts(recordings_, false, 1);
  for (const char* architecture : {"tnn_19", "tnn_21"}) {
    ForceTrainingOptions options;
    options.architecture = architecture;
    options.epochs = 6;
    options.epoch_size = 2048;
    const ForceErrors errors = Test(Train(options));
    EXPECT_LT(errors.smse.maxCoeff(), 0.9) << architecture << "\n" << errors.smse.transpose();
  }
}

TEST_F(TrainForceTest, ThePapersOptimiserLearnsToo) {
  ForceTrainingOptions options;
  options.architecture = "dnn_21";
  options.descent = Descent::kSgd;
  options.batch = 32;
  options.epochs = 40;
  const LearntForce learnt = Train(options);
  EXPECT_LT(Test(learnt).smse.maxCoeff(), 0.1);
  EXPECT_LT(learnt.epochs.back().loss, 0.2 * learnt.epochs.front().loss);
}

TEST_F(TrainForceTest, WeightsDoNotDependOnTheNumberOfThreads) {
  ForceTrainingOptions options;
  options.epochs = 1;
  options.epoch_size = 700;  // the last batch is a part of one
  options.threads = 1;
  const LearntForce alone = Train(options);
  options.threads = 3;
  const LearntForce together = Train(options);
  EXPECT_EQ(alone.epochs[0].loss, together.epochs[0].loss);
  EXPECT_EQ(alone.weights.lstm[0].kernel, together.weights.lstm[0].kernel);
  EXPECT_EQ(alone.weights.lstm[1].bias, together.weights.lstm[1].bias);
  EXPECT_EQ(alone.weights.dense[0].kernel, together.weights.dense[0].kernel);
  options.seed = 2;
  EXPECT_NE(alone.weights.dense[0].kernel, Train(options).weights.dense[0].kernel);
}

// Figures of the validation from which the weights come: the least of all epochs.
TEST_F(TrainForceTest, StopsEarlyAndKeepsTheBestEpoch) {
  ForceTrainingOptions options;
  options.architecture = "dnn_21";
  options.epochs = 400;
  options.patience = 3;
  options.rate = 0.02;
  const LearntForce learnt = Train(options);
  EXPECT_LT(learnt.epochs.size(), 400U);
  EXPECT_FALSE(learnt.stopped);
  EXPECT_EQ(learnt.epochs.size(), static_cast<std::size_t>(learnt.best_epoch + 3));
  const double best =
      learnt.epochs[static_cast<std::size_t>(learnt.best_epoch - 1)].validation_loss;
  for (const TrainingEpoch& e : learnt.epochs) EXPECT_GE(e.validation_loss, best);
}

TEST_F(TrainForceTest, OnRequestStopsWithTheBestSoFar) {
  ForceTrainingOptions options;
  options.architecture = "dnn_21";
  options.epochs = 5;
  const LearntForce whole = Train(options);
  StopAfter soon(1 + static_cast<int>(whole.train_windows) / options.batch + 10);
  const LearntForce learnt = TrainForce(recordings_, split_, options, soon);
  EXPECT_TRUE(learnt.stopped);
  EXPECT_EQ(learnt.epochs.size(), 1U);
  EXPECT_EQ(learnt.epochs[0].loss, whole.epochs[0].loss);
  StopAfter at_once(0);
  EXPECT_THROW(TrainForce(recordings_, split_, options, at_once), Interrupted);
}

TEST_F(TrainForceTest, SignalsThatWereNotRecordedDoNoHarm) {
  for (LabelledRecording& r : recordings_) {
    for (TactileSignals& change : r.change) change[19] = change[20] = change[7] = 0;
  }
  ForceTrainingOptions options;
  options.architecture = "dnn_21";
  options.epochs = 8;
  EXPECT_LT(Test(Train(options)).smse.maxCoeff(), 0.1);
}

TEST_F(TrainForceTest, RefusesWhatCannotBeLearnt) {
  const auto refused = [&](auto change) {
    auto recordings = recordings_;
    Split split = split_;
    ForceTrainingOptions options;
    options.architecture = "dnn_21";
    options.epochs = 1;
    change(&recordings, &split, &options);
    Quiet progress;
    EXPECT_THROW(TrainForce(recordings, split, options, progress), std::invalid_argument);
  };
  using Set = std::vector<LabelledRecording>;
  refused([](Set*, Split*, ForceTrainingOptions* o) { o->architecture = "rnn_20"; });
  refused([](Set*, Split*, ForceTrainingOptions* o) { o->rate = -1; });
  refused([](Set*, Split*, ForceTrainingOptions* o) { o->rate = std::nan(""); });
  refused([](Set*, Split*, ForceTrainingOptions* o) { o->epochs = 0; });
  refused([](Set*, Split*, ForceTrainingOptions* o) { o->threads = 0; });
  refused([](Set*, Split* s, ForceTrainingOptions*) { s->train = {{0, 0, 60, 0}}; });
  refused([](Set*, Split* s, ForceTrainingOptions*) { s->validation.clear(); });
  refused([](Set* r, Split*, ForceTrainingOptions*) {
    for (auto& recording : *r) {
      for (auto& f : recording.force) f = {0.1F, 0.2F, -0.3F};
    }
  });
  refused([](Set* r, Split*, ForceTrainingOptions*) {
    for (auto& recording : *r) {
      for (auto& change : recording.change) change.fill(0);
    }
  });
  const float nan = std::nanf("");
  refused([&](Set* r, Split*, ForceTrainingOptions*) {
    for (auto& x : *r) x.change[150][3] = nan;
  });
  refused([&](Set* r, Split*, ForceTrainingOptions*) {
    for (auto& x : *r) x.force[150].y() = nan;
  });
}

}  // namespace
}  // namespace palpate
