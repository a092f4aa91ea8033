#include <array>
#include <cmath>
#include <limits>
#include <random>

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include "slave/tactile/network/force_network.h"
#include "tests/slave/tactile/network/onnx_writer.h"
#include "tests/slave/tactile/network/reference_network.h"
#include "tests/support/scratch.h"

namespace palpate {
namespace {

using ::testing::EndsWith;
using ::testing::HasSubstr;

constexpr long kHidden = 8, kOutputs = 3;

OnnxWeights Random(const std::string& name, const std::vector<long>& extents, unsigned seed) {
  std::mt19937 random(seed);
  std::uniform_real_distribution<float> within(-0.05f, 0.05f);
  OnnxWeights weights{name, extents, {}};
  long count = 1;
  for (const long extent : extents) count *= extent;
  for (long k = 0; k < count; ++k) weights.data.push_back(within(random));
  return weights;
}

// y = tanh(x W^T + b) V^T + c, with n inputs. (Gemm without transB is none that OpenCV 4.6 takes.)
struct TwoLayers {
  explicit TwoLayers(long count)
      : W(Random("W", {kHidden, count}, 1)),
        b(Random("b", {kHidden}, 2)),
        V(Random("V", {kOutputs, kHidden}, 3)),
        c(Random("c", {kOutputs}, 4)),
        n(count) {}
  [[nodiscard]] std::string Model(const std::vector<long>& input,
                                  const std::string& hidden = "Tanh") const {
    return OnnxModel(input, {1, kOutputs},
                     {{"Gemm", {"x", "W", "b"}, "z", {{"transB", 1}}},
                      {hidden, {"z"}, "h"},
                      {"Gemm", {"h", "V", "c"}, "y", {{"transB", 1}}}},
                     {W, b, V, c});
  }
  [[nodiscard]] std::array<double, 3> Evaluate(
      const TactileSignals& x,
      double (*activation)(double) = [](double z) { return std::tanh(z); }) const {
    std::array<double, 3> y{};
    for (std::size_t k = 0; k < 3; ++k) y[k] = static_cast<double>(c.data[k]);
    for (std::size_t j = 0; j < kHidden; ++j) {
      double z = static_cast<double>(b.data[j]);
      for (std::size_t i = 0; i < static_cast<std::size_t>(n); ++i) {
        z += static_cast<double>(x[i]) *
             static_cast<double>(W.data[j * static_cast<std::size_t>(n) + i]);
      }
      for (std::size_t k = 0; k < 3; ++k) {
        y[k] += activation(z) * static_cast<double>(V.data[k * kHidden + j]);
      }
    }
    return y;
  }
  OnnxWeights W, b, V, c;
  long n;
};

std::string ErrorOf(const std::string& bytes) {
  const Scratch scratch;
  try {
    LoadForceNetwork(scratch.Write("model.onnx", bytes));
    return "";
  } catch (const std::runtime_error& error) {
    return error.what();
  }
}

// Reference: the formula in double precision. Tolerance: OpenCV computes in single precision, sums
// of 21 terms up to 5 counts, and outputs up to 0.4.
TEST(OnnxNetworkTest, AModelOfOneSampleIsItsFormula) {
  const Scratch scratch;
  for (const long n : {19, 21}) {
    for (const long batch : {0, 1}) {
      const TwoLayers layers(n);
      const auto network = LoadForceNetwork(scratch.Write("model.onnx", layers.Model({batch, n})));
      EXPECT_EQ(network->info().architecture, "onnx");
      EXPECT_EQ(network->info().inputs, n);
      EXPECT_EQ(network->info().window, 1);
      EXPECT_EQ(network->info().outputs, 3);
      const auto estimate = network->Windowed();
      for (const TactileSignals& sample : RandomSignals(20, 100, 5)) {
        std::array<double, 3> outputs{};
        ASSERT_TRUE(estimate->Push(sample, outputs));
        const auto expected = layers.Evaluate(sample);
        for (std::size_t k = 0; k < 3; ++k) ASSERT_NEAR(outputs[k], expected[k], 1e-5);
      }
    }
  }
}

// The window goes in with the oldest sample first: Flatten and a Gemm that looks at one number of
// each sample.
TEST(OnnxNetworkTest, AModelOfAWindowTakesItsSamplesInOrder) {
  constexpr long kWindow = 4, kInputs = 19;
  OnnxWeights W{"W", {3, kWindow * kInputs}, std::vector<float>(kWindow * kInputs * 3)};
  OnnxWeights b{"b", {3}, {0, 0, 0}};
  W.data[0] = 1;                          // y0: E1 of the oldest
  W.data[2 * kWindow * kInputs - 1] = 1;  // y1: E19 of the newest
  for (std::size_t t = 0; t < kWindow; ++t)
    W.data[(2 * kWindow + t) * kInputs] = static_cast<float>(t);
  const Scratch scratch;
  const auto network = LoadForceNetwork(scratch.Write(
      "model.onnx",
      OnnxModel({1, kWindow, kInputs}, {1, 3},
                {{"Flatten", {"x"}, "f"}, {"Gemm", {"f", "W", "b"}, "y", {{"transB", 1}}}},
                {W, b})));
  ASSERT_EQ(network->info().window, kWindow);
  const auto estimate = network->Windowed();
  const auto samples = RandomSignals(12, 100, 6);
  const auto value = [&](std::size_t t, std::size_t i) {
    return static_cast<double>(samples[t][i]);
  };
  for (std::size_t t = 0; t < samples.size(); ++t) {
    std::array<double, 3> y{};
    if (t == 6) {
      TactileSignals broken{};
      broken[3] = std::numeric_limits<float>::quiet_NaN();
      EXPECT_FALSE(estimate->Push(broken, y)) << "and the window starts anew";
    }
    const bool full = estimate->Push(samples[t], y);
    ASSERT_EQ(full, t == 3 || t == 4 || t == 5 || t >= 9) << t;
    if (!full) continue;
    EXPECT_NEAR(y[0], value(t - 3, 0), 1e-4);
    EXPECT_NEAR(y[1], value(t, 18), 1e-4);
    EXPECT_NEAR(y[2], value(t - 2, 0) + 2 * value(t - 1, 0) + 3 * value(t, 0), 1e-3);
  }
}

TEST(OnnxNetworkTest, AnUnknownOperatorIsNamed) {
  testing::internal::CaptureStderr();
  const std::string error = ErrorOf(TwoLayers(21).Model({1, 21}, "Feel"));
  EXPECT_NE(error.find("model.onnx: operator Feel: is not supported: accepted is one of Gemm "),
            std::string::npos)
      << error;
  EXPECT_EQ(testing::internal::GetCapturedStderr(), "") << "the error says it";
}

TEST(OnnxNetworkTest, AModelCutOffAnywhereIsRefused) {
  testing::internal::CaptureStderr();
  const std::string whole = TwoLayers(19).Model({1, 19});
  for (std::size_t size = 0; size < whole.size(); size += 1 + size / 20) {
    EXPECT_NE(ErrorOf(whole.substr(0, size)), "") << "after " << size << " bytes";
  }
  EXPECT_NE(ErrorOf("this is no model"), "");
  EXPECT_NE(ErrorOf(std::string(1000, '\0')), "");
  EXPECT_EQ(testing::internal::GetCapturedStderr(), "");
}

TEST(OnnxNetworkTest, OtherShapesAreRefusedWithTheirExtents) {
  EXPECT_NE(ErrorOf(TwoLayers(13).Model({1, 13})).find("[1, 13], expected [1, n]"),
            std::string::npos);
  EXPECT_NE(ErrorOf(TwoLayers(21).Model({4, 21})).find("[4, 21], expected"), std::string::npos);
  EXPECT_NE(ErrorOf(TwoLayers(21).Model({21})).find("[21], expected"), std::string::npos);
  EXPECT_NE(ErrorOf(TwoLayers(21).Model({1, 100000, 21})).find("expected"), std::string::npos);
  const std::string two =
      OnnxModel({1, 21}, {1, 2}, {{"Gemm", {"x", "W", "b"}, "y", {{"transB", 1}}}},
                {Random("W", {2, 21}, 7), Random("b", {2}, 8)});
  EXPECT_NE(ErrorOf(two).find("expected one row of 3 or more"), std::string::npos) << ErrorOf(two);
  // Weights that do not fit the input.
  EXPECT_NE(ErrorOf(TwoLayers(19).Model({1, 21})), "");
}

// OpenCV takes no notice of these: forces would be wrong by the factor.
TEST(OnnxNetworkTest, AGemmThatWouldBeComputedOtherwiseIsRefused) {
  const auto error = [](std::map<std::string, long> attributes,
                        std::map<std::string, float> factors) {
    return ErrorOf(
        OnnxModel({1, 21}, {1, 3},
                  {{"Gemm", {"x", "W", "b"}, "y", std::move(attributes), std::move(factors)}},
                  {Random("W", {3, 21}, 7), Random("b", {3}, 8)}));
  };
  EXPECT_EQ(error({{"transB", 1}, {"transA", 0}}, {{"alpha", 1}, {"beta", 1}}), "");
  EXPECT_THAT(error({{"transB", 1}}, {{"alpha", 2}}),
              EndsWith("model.onnx: operator Gemm: alpha = 2: accepted is alpha = 1"));
  EXPECT_THAT(error({{"transB", 1}}, {{"beta", 0.5F}}),
              EndsWith("Gemm: beta = 0.5: accepted is beta = 1"));
  EXPECT_THAT(error({{"transB", 1}, {"transA", 1}}, {}), HasSubstr("Gemm: transA = 1: accepted"));
  for (const auto& attributes : {std::map<std::string, long>{}, {{"transB", 0}}}) {
    EXPECT_THAT(error(attributes, {}),
                EndsWith("Gemm: transB = 0: accepted is transB = 1, or MatMul and Add"));
  }
}

// Each of these OpenCV would compute otherwise than ONNX defines it, or not at all.
TEST(OnnxNetworkTest, OperatorsThatWouldBeComputedOtherwiseAreNamed) {
  const OnnxWeights row = Random("k", {19}, 9), W = Random("W", {3, 19 * 19}, 10);
  const auto window = [&](const std::string& op) {
    return ErrorOf(OnnxModel({1, 19, 19}, {1, 3},
                             {{op, {"x", "k"}, "s"},
                              {"Flatten", {"s"}, "f"},
                              {"Gemm", {"f", "W"}, "y", {{"transB", 1}}}},
                             {row, W}));
  };
  for (const char* op : {"Add", "Sub", "Mul", "Div"}) {
    EXPECT_THAT(window(op), HasSubstr(std::string("operator ") + op + ": constant k on a window"));
  }
  const auto recurrent = [](const std::string& op, std::vector<std::string> inputs,
                            std::map<std::string, long> attributes,
                            std::map<std::string, float> factors) {
    attributes["hidden_size"] = 3;
    const long gates = op == "LSTM" ? 4 : 3;
    return ErrorOf(OnnxModel(
        {1, 5, 19}, {1, 3},
        {{op, std::move(inputs), "y", std::move(attributes), std::move(factors)}},
        {Random("W", {1, 3 * gates, 19}, 1), Random("R", {1, 3 * gates, 3}, 2),
         Random("B", {1, 6 * gates}, 3), Random("h", {1, 1, 3}, 4), Random("P", {1, 9}, 5)}));
  };
  EXPECT_THAT(recurrent("LSTM", {"x", "W", "R", "B"}, {}, {{"clip", 0.5F}}),
              HasSubstr("operator LSTM: attribute clip = 0.5"));
  EXPECT_THAT(recurrent("LSTM", {"x", "W", "R", "B", "", "h", "h", "P"}, {}, {}),
              HasSubstr("operator LSTM: has an input P"));
  EXPECT_THAT(
      recurrent("GRU", {"x", "W", "R", "B", "", "h"}, {}, {}),
      HasSubstr("operator GRU: linear_before_reset = 0: accepted is linear_before_reset = 1"));
  EXPECT_THAT(recurrent("GRU", {"x", "W", "R", "B"}, {{"linear_before_reset", 1}}, {}),
              HasSubstr("operator GRU: has no input initial_h"));
}

// Reference: the formulas of ONNX in double precision. Tolerance as above.
TEST(OnnxNetworkTest, EveryActivationOnTheListIsItsFormula) {
  const std::map<std::string, double (*)(double)> formulas{
      {"Relu", [](double z) { return std::max(z, 0.0); }},
      {"Sigmoid", [](double z) { return 1 / (1 + std::exp(-z)); }},
      {"LeakyRelu", [](double z) { return z < 0 ? 0.01 * z : z; }},
      {"Elu", [](double z) { return z < 0 ? std::exp(z) - 1 : z; }},
      {"Identity", [](double z) { return z; }}};
  const Scratch scratch;
  const TwoLayers layers(19);
  for (const auto& [name, formula] : formulas) {
    const auto network = LoadForceNetwork(scratch.Write("model.onnx", layers.Model({1, 19}, name)));
    const auto estimate = network->Windowed();
    for (const TactileSignals& sample : RandomSignals(10, 100, 5)) {
      std::array<double, 3> outputs{};
      ASSERT_TRUE(estimate->Push(sample, outputs)) << name;
      const auto expected = layers.Evaluate(sample, formula);
      for (std::size_t k = 0; k < 3; ++k) ASSERT_NEAR(outputs[k], expected[k], 1e-4) << name;
    }
  }
}

// OpenCV would divide by zero.
TEST(OnnxNetworkTest, WeightsWithoutTheirDataAreRefused) {
  TwoLayers layers(21);
  layers.W.data.pop_back();
  EXPECT_NE(ErrorOf(layers.Model({1, 21})).find("weights W do not fill their extents"),
            std::string::npos);
  layers.W.data.clear();
  EXPECT_NE(ErrorOf(layers.Model({1, 21})).find("weights W do not fill their extents"),
            std::string::npos);
}

TEST(OnnxNetworkTest, WeightsThatAreNotFiniteAreRefused) {
  TwoLayers layers(21);
  layers.c.data[0] = std::numeric_limits<float>::quiet_NaN();
  EXPECT_NE(ErrorOf(layers.Model({1, 21})).find("not finite"), std::string::npos);
}

}  // namespace
}  // namespace palpate
