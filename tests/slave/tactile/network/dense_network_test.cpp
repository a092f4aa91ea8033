#include <array>
#include <span>

#include <gtest/gtest.h>

#include "tests/slave/tactile/network/reference_network.h"

namespace palpate {
namespace {

using Outputs = std::array<double, 4>;

// Reference: the formulas, in double precision here and there; they differ in the order of sums.
TEST(DenseNetworkTest, EverySampleIsTheReference) {
  for (const char* architecture : {"dnn_21", "dnn_19"}) {
    for (const auto activation :
         {HiddenActivation::kTanh, HiddenActivation::kRelu, HiddenActivation::kSigmoid,
          HiddenActivation::kElu, HiddenActivation::kLeakyRelu, HiddenActivation::kIdentity}) {
      RandomNetwork network = MakeRandomNetwork(architecture, 33, 0.5f, 1);
      for (DenseLayer& layer : network.weights.dense) layer.activation = activation;
      const auto made = MakeForceNetwork(network.info, network.weights);
      const auto windowed = made->Windowed();
      for (const TactileSignals& sample : RandomSignals(100, 4095, 2)) {
        Outputs outputs{};
        ASSERT_TRUE(windowed->Push(sample, outputs));
        const auto expected = ReferenceOutputs(network.info, network.weights, {&sample, 1});
        for (std::size_t k = 0; k < expected.size(); ++k) {
          ASSERT_NEAR(outputs[k], expected[k], 1e-12 * (1 + std::abs(expected[k])));
        }
      }
    }
  }
}

// Reference: the formula over all samples.
TEST(DenseNetworkTest, TracesAreTheReference) {
  for (const char* architecture : {"tnn_21", "tnn_19"}) {
    const RandomNetwork network = MakeRandomNetwork(architecture, 20, 0.3f, 7);
    const auto estimate = MakeForceNetwork(network.info, network.weights)->Windowed();
    const auto samples = RandomSignals(200, 300, 8);
    Outputs outputs{};
    for (std::size_t t = 0; t < samples.size(); ++t) {
      ASSERT_EQ(estimate->Push(samples[t], outputs), t >= 49) << "the window";
      if (t % 25 != 24 || t < 49) continue;
      const auto expected =
          ReferenceOutputs(network.info, network.weights, std::span(samples).first(t + 1));
      for (std::size_t k = 0; k < expected.size(); ++k) {
        EXPECT_NEAR(outputs[k], expected[k], 1e-12 * (1 + std::abs(expected[k])));
      }
    }
    estimate->Reset();
    EXPECT_FALSE(estimate->Push(samples[0], outputs));
  }
}

}  // namespace
}  // namespace palpate
