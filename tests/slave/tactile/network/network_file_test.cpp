#include "slave/tactile/network/network_file.h"

#include <array>
#include <functional>
#include <limits>
#include <string>

#include <gtest/gtest.h>
#include <nlohmann/json.hpp>

#include "tests/slave/tactile/network/reference_network.h"
#include "tests/support/scratch.h"

namespace palpate {
namespace {

using nlohmann::json;

std::string ErrorOf(const std::filesystem::path& path) {
  try {
    LoadForceNetwork(path);
    return "";
  } catch (const std::runtime_error& error) {
    return error.what();
  }
}

// A sound network's file, changed.
class BrokenNetworkTest : public testing::Test {
 protected:
  BrokenNetworkTest() {
    sound_ = JsonOf(MakeRandomNetwork("rnn_21", 5, 0.3f, 1)).dump();
    scratch_.Write("network.json", sound_);
  }
  std::string ErrorAfter(const std::function<void(json*)>& change) {
    json root = json::parse(sound_);
    change(&root);
    return ErrorOfText(root.dump());
  }
  std::string ErrorOfText(const std::string& text) {
    scratch_.Write("network.json", text);
    return ErrorOf(scratch_.path());
  }
  Scratch scratch_;
  std::string sound_;
};

#define EXPECT_SAYS(error, words) \
  EXPECT_NE((error).find(words), std::string::npos) << "it says: " << (error)

// Every number comes back as it was, also those with the longest decimals and the smallest.
TEST(NetworkFileTest, WhatIsWrittenIsReadExactly) {
  for (const char* architecture : {"rnn_21", "rnn_19", "dnn_21", "dnn_19", "tnn_21", "tnn_19"}) {
    RandomNetwork network = MakeRandomNetwork(architecture, 20, 1, 2);
    network.info.gain = 1.0 / 3;
    network.weights.dense[0].bias[0] = std::numeric_limits<float>::denorm_min();
    network.weights.dense[0].bias[1] = std::numeric_limits<float>::max();
    json root = JsonOf(network);
    root["sigma"] = {0.1, 0.02, 1e-7};
    root["learnt_force"] = 4.9;
    root["rest_sigma"] = 0.014;
    root["growing_variance"] = 0.002;
    root["relative_sigma"] = 0.11;
    root["activation"] = "relu";
    const Scratch scratch;
    scratch.Write("network.json", root.dump());
    const NetworkFile read = ReadForceNetwork(scratch.path());
    EXPECT_EQ(read.info.architecture, architecture);
    EXPECT_EQ(read.info.inputs, network.info.inputs);
    EXPECT_EQ(read.info.window, network.info.window);
    EXPECT_EQ(read.info.gain, network.info.gain);
    EXPECT_EQ(read.info.sigma, Eigen::Vector3d(0.1, 0.02, 1e-7));
    EXPECT_EQ(read.info.learnt_force, 4.9);
    EXPECT_EQ(read.info.rest_sigma, 0.014);
    EXPECT_EQ(read.info.error.growing, 0.002);
    EXPECT_EQ(read.info.error.relative, 0.11);
    EXPECT_EQ(read.weights.input_mean, network.weights.input_mean);
    EXPECT_EQ(read.weights.input_scale, network.weights.input_scale);
    EXPECT_EQ(read.weights.output_mean, network.weights.output_mean);
    EXPECT_EQ(read.weights.output_scale, network.weights.output_scale);
    ASSERT_EQ(read.weights.lstm.size(), network.weights.lstm.size());
    ASSERT_EQ(read.weights.dense.size(), network.weights.dense.size());
    for (std::size_t k = 0; k < read.weights.lstm.size(); ++k) {
      EXPECT_EQ(read.weights.lstm[k].kernel, network.weights.lstm[k].kernel);
      EXPECT_EQ(read.weights.lstm[k].bias, network.weights.lstm[k].bias);
    }
    for (std::size_t k = 0; k < read.weights.dense.size(); ++k) {
      EXPECT_EQ(read.weights.dense[k].kernel, network.weights.dense[k].kernel);
      EXPECT_EQ(read.weights.dense[k].bias, network.weights.dense[k].bias);
      EXPECT_EQ(read.weights.dense[k].activation, HiddenActivation::kRelu);
    }
    EXPECT_EQ(LoadForceNetwork(scratch.path())->info().gain, network.info.gain);
  }
}

TEST(NetworkFileTest, WeightsThatAreNoNumbersAreRefused) {
  RandomNetwork network = MakeRandomNetwork("rnn_21", 5, 0.3f, 4);
  network.weights.lstm[1].bias[3] = std::numeric_limits<float>::quiet_NaN();
  EXPECT_THROW(MakeForceNetwork(network.info, network.weights), std::invalid_argument);
}

TEST_F(BrokenNetworkTest, TextThatIsCutOffIsNoJson) {
  EXPECT_EQ(ErrorOfText(sound_), "");
  for (std::size_t size = 0; size < sound_.size() - 2; size += 1 + size / 10) {
    EXPECT_SAYS(ErrorOfText(sound_.substr(0, size)), "network.json: not JSON") << size;
  }
  EXPECT_SAYS(ErrorOfText("[]"), "palpate_force_network is missing");
  EXPECT_SAYS(ErrorOfText(std::string(100000, '[')), "not JSON");
}

TEST_F(BrokenNetworkTest, TensorsOfTheWrongShapeAreNamedWithWhatIsExpected) {
  EXPECT_SAYS(ErrorAfter([](json* root) { (*root)["lstm"][0]["kernel"].erase(0); }),
              "lstm[0].kernel is 25 x 20, expected 26 x 20");
  EXPECT_SAYS(ErrorAfter([](json* root) { (*root)["lstm"][1]["kernel"][2].erase(0); }),
              "lstm[1].kernel[2] has 19 numbers, expected 20");
  EXPECT_SAYS(ErrorAfter([](json* root) { (*root)["lstm"][1]["bias"].push_back(1); }),
              "lstm[1].bias has 21 numbers, expected 20");
  EXPECT_SAYS(ErrorAfter([](json* root) {
                (*root)["dense"][0]["kernel"].push_back({1, 2, 3, 4});
              }),
              "dense[0].kernel is 6 x 4, expected 5 x 4");
  EXPECT_SAYS(ErrorAfter([](json* root) {
                (*root)["input"]["mean"] = {1, 2};
              }),
              "input.mean has 2 numbers, expected 21");
  EXPECT_SAYS(ErrorAfter([](json* root) { (*root)["dense"] = json::array(); }), "no dense layer");
  EXPECT_SAYS(ErrorAfter([](json* root) { (*root)["architecture"] = "rnn_19"; }),
              "inputs = 21: rnn_19 has 19");
  EXPECT_SAYS(ErrorAfter([](json* root) { (*root)["architecture"] = "cnn"; }),
              "architecture = cnn: expected rnn_21, rnn_19, dnn_21, dnn_19, tnn_21, tnn_19");
  EXPECT_SAYS(ErrorAfter([](json* root) { (*root)["lstm"][0]["kernel"] = json::array(); }),
              "lstm[0].kernel: not a list of rows");
}

TEST_F(BrokenNetworkTest, NumbersThatAreNoneAreNamed) {
  EXPECT_SAYS(ErrorAfter([](json* root) { (*root)["lstm"][0]["kernel"][1][2] = nullptr; }),
              "lstm[0].kernel[1][2]: not a number");
  EXPECT_SAYS(ErrorAfter([](json* root) { (*root)["lstm"][0]["bias"][7] = 1e39; }),
              "lstm[0].bias[7]: beyond single precision");
  EXPECT_SAYS(ErrorAfter([](json* root) { (*root)["dense"][0]["bias"][0] = "NaN"; }),
              "dense[0].bias[0]: not a number");
  const std::string beyond = [&] {
    std::string text = sound_;
    return text.replace(text.find("\"rate\":100"), 10, "\"rate\":1e999");
  }();
  EXPECT_NE(ErrorOfText(beyond), "");
  EXPECT_SAYS(ErrorAfter([](json* root) { (*root)["window"] = 1e9; }), "window");
  EXPECT_SAYS(ErrorAfter([](json* root) { (*root)["window"] = 0; }), "window = 0: expected 1 to");
  EXPECT_SAYS(ErrorAfter([](json* root) { (*root)["inputs"] = -1; }), "inputs");
  EXPECT_SAYS(ErrorAfter([](json* root) { (*root)["outputs"] = 2; }), "outputs = 2: expected 3");
  EXPECT_SAYS(ErrorAfter([](json* root) { (*root)["rate"] = 0; }), "rate");
  EXPECT_SAYS(ErrorAfter([](json* root) { (*root)["gain"] = 0; }), "gain");
  EXPECT_SAYS(ErrorAfter([](json* root) { (*root)["sigma"] = {1, 2}; }), "sigma");
  EXPECT_SAYS(ErrorAfter([](json* root) {
                (*root)["sigma"] = {1, -2, 3};
              }),
              "sigma: expected three numbers >= 0");
  for (const char* key : {"rest_sigma", "learnt_force", "growing_variance", "relative_sigma"}) {
    EXPECT_SAYS(ErrorAfter([&](json* root) { (*root)[key] = -1; }),
                std::string(key) + ": expected a number >= 0");
  }
  EXPECT_SAYS(ErrorAfter([](json* root) { (*root)["input"]["scale"][20] = 0; }),
              "input.scale contains a 0");
  EXPECT_SAYS(ErrorAfter([](json* root) { (*root)["palpate_force_network"] = 2; }),
              "palpate_force_network: expected 1");
  EXPECT_SAYS(ErrorAfter([](json* root) { (*root)["activation"] = "selu"; }),
              "activation = selu: expected tanh, relu");
}

}  // namespace
}  // namespace palpate
