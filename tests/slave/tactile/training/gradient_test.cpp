#include <array>
#include <memory>
#include <random>
#include <string>
#include <vector>

#include <gtest/gtest.h>

#include "slave/tactile/training/batch_gradient.h"

namespace palpate {
namespace {

struct Case {
  const char* name;
  std::unique_ptr<BatchGradient> (*make)();
};

class BatchGradientTest : public ::testing::TestWithParam<Case> {
 protected:
  BatchGradientTest() : network_(GetParam().make()), weights_(network_->Initial(3)) {
    std::mt19937 random(5);
    std::uniform_real_distribution<float> unit(-1, 1);
    for (int t = 0; t < network_->steps(); ++t) {
      batch_.push_back(
          Eigen::MatrixXf::NullaryExpr(7, network_->inputs(), [&] { return unit(random); }));
    }
    truth_ = Eigen::MatrixXf::NullaryExpr(7, 3, [&] { return unit(random); });
    // Biases start at zero; away from it every term of their gradients is met.
    for (float& w : weights_) w += 0.1F * unit(random);
  }

  double Loss(const Eigen::VectorXf& weights) {
    return 0.5 * (network_->Forward(weights, batch_) - truth_).cast<double>().squaredNorm();
  }
  Eigen::VectorXf Gradient() {
    Eigen::VectorXf gradient = Eigen::VectorXf::Zero(weights_.size());
    const Eigen::MatrixXf residual = network_->Forward(weights_, batch_) - truth_;
    network_->Backward(weights_, residual, &gradient);
    return gradient;
  }

  std::unique_ptr<BatchGradient> network_;
  Eigen::VectorXf weights_;
  std::vector<Eigen::MatrixXf> batch_;
  Eigen::MatrixXf truth_;
};

// Reference: central differences of the loss, weight by weight. Tolerance: with h = 4e-3 they
// truncate at about h^2 / 6 = 3e-6 of the third derivative, and single precision rounds at
// 1e-7 L / h = 2e-4 for L = 7; the worst measured is 4e-4, gradients are up to 6.
TEST_P(BatchGradientTest, EveryWeightsGradientIsThatOfFiniteDifferences) {
  constexpr float kStep = 4e-3F;
  const Eigen::VectorXf gradient = Gradient();
  ASSERT_EQ(gradient.size(), network_->weight_count());
  EXPECT_GT(gradient.norm(), 1);
  for (Eigen::Index i = 0; i < weights_.size(); ++i) {
    Eigen::VectorXf more = weights_, less = weights_;
    more[i] += kStep;
    less[i] -= kStep;
    const double width = static_cast<double>(more[i]) - static_cast<double>(less[i]);
    EXPECT_NEAR((Loss(more) - Loss(less)) / width, static_cast<double>(gradient[i]), 1.5e-3)
        << "weight " << i;
  }
}

TEST_P(BatchGradientTest, GradientsOfTwoBatchesAddUp) {
  const Eigen::VectorXf once = Gradient();
  Eigen::VectorXf twice = once;
  const Eigen::MatrixXf residual = network_->Forward(weights_, batch_) - truth_;
  network_->Backward(weights_, residual, &twice);
  EXPECT_TRUE(twice.isApprox(2 * once, 1e-6F));
}

// A sample's output does not depend on its neighbours in the batch. Tolerance: sums of at most 41
// products in another order, single precision.
TEST_P(BatchGradientTest, EachRowOfABatchIsASampleOfItsOwn) {
  const Eigen::MatrixXf together = network_->Forward(weights_, batch_);
  for (Eigen::Index row = 0; row < together.rows(); ++row) {
    std::vector<Eigen::MatrixXf> alone;
    for (const Eigen::MatrixXf& step : batch_) alone.emplace_back(step.row(row));
    const Eigen::MatrixXf& output = network_->Forward(weights_, alone);
    EXPECT_LT((output - together.row(row)).cwiseAbs().maxCoeff(), 1e-5F) << "row " << row;
  }
}

TEST_P(BatchGradientTest, TheSameSeedStartsWithTheSameWeights) {
  EXPECT_EQ(network_->Initial(11), network_->Initial(11));
  EXPECT_NE(network_->Initial(11), network_->Initial(12));
}

// Networks with a fingertip's inputs, which the inference accepts.
class FingertipGradientTest : public BatchGradientTest {};

// Reference: NetworkWeights evaluated by the house's inference, written apart from training.
// Tolerance: fifty steps in single precision.
TEST_P(FingertipGradientTest, TheLayersHandedOverComputeTheSame) {
  NetworkInfo info;
  info.inputs = network_->inputs();
  info.architecture =
      std::string(network_->steps() > 1 ? "rnn_" : "dnn_") + std::to_string(network_->inputs());
  info.window = network_->steps();
  info.outputs = 3;
  NetworkWeights layers;
  layers.LeaveUnscaled(info.inputs, 3);
  network_->FillLayers(weights_, &layers);
  const auto network = MakeForceNetwork(info, layers);
  const Eigen::MatrixXf expected = network_->Forward(weights_, batch_);
  for (Eigen::Index row = 0; row < expected.rows(); ++row) {
    const auto estimate = network->Windowed();
    std::array<double, 3> outputs{};
    bool full = false;
    for (const Eigen::MatrixXf& step : batch_) {
      TactileSignals signals{};
      for (Eigen::Index i = 0; i < step.cols(); ++i) {
        signals[static_cast<std::size_t>(i)] = step(row, i);
      }
      full = estimate->Push(signals, outputs);
    }
    ASSERT_TRUE(full);
    for (Eigen::Index axis = 0; axis < 3; ++axis) {
      EXPECT_NEAR(outputs[static_cast<std::size_t>(axis)], static_cast<double>(expected(row, axis)),
                  1e-5)
          << "row " << row << ", axis " << axis;
    }
  }
}

std::string NameOf(const ::testing::TestParamInfo<Case>& one) {
  return one.param.name;
}

INSTANTIATE_TEST_SUITE_P(
    Networks, BatchGradientTest,
    ::testing::Values(Case{"SmallLstm", [] { return MakeLstmGradient(4, 3, 6); }},
                      Case{"OneStepLstm", [] { return MakeLstmGradient(3, 2, 1); }},
                      Case{"SmallDense",
                           [] {
                             return MakeDenseGradient(4, {5, 6});
                           }},
                      Case{"LinearOnly", [] { return MakeDenseGradient(4, {}); }}),
    NameOf);
INSTANTIATE_TEST_SUITE_P(
    Networks, FingertipGradientTest,
    ::testing::Values(Case{"ElectrodesLstm", [] { return MakeLstmGradient(19, 20, 50); }},
                      Case{"PressureLstm", [] { return MakeLstmGradient(21, 4, 12); }},
                      Case{"ElectrodesDense", [] { return MakeDenseGradient(19, {8}); }},
                      Case{"PressureDense",
                           [] {
                             return MakeDenseGradient(21, {38, 38});
                           }}),
    NameOf);

}  // namespace
}  // namespace palpate
