#include "slave/tactile/network/network_file.h"

#include <functional>
#include <limits>
#include <string>
#include <vector>

#include <gmock/gmock.h>
#include <gtest/gtest.h>
#include <nlohmann/json.hpp>

#include "tests/slave/tactile/network/reference_network.h"
#include "tests/support/scratch.h"
#include "tests/support/thrown.h"

namespace palpate {
namespace {

using nlohmann::json;

// Every number is read back exactly, including those with the longest decimals and the smallest.
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

struct Flaw {
  const char* name;
  std::function<void(json*)> apply;
  const char* words;
};

class FlawedNetworkTest : public testing::TestWithParam<Flaw> {};

TEST_P(FlawedNetworkTest, IsRefusedInWords) {
  json root = JsonOf(MakeRandomNetwork("rnn_21", 5, 0.3f, 1));
  GetParam().apply(&root);
  const Scratch scratch;
  scratch.Write("network.json", root.dump());
  EXPECT_THAT(Thrown<std::runtime_error>([&] { LoadForceNetwork(scratch.path()); }),
              testing::HasSubstr(GetParam().words));
}

INSTANTIATE_TEST_SUITE_P(
    All, FlawedNetworkTest,
    testing::Values(
        Flaw{"NoNetwork", [](json* root) { *root = json::array(); },
             "palpate_force_network is missing"},
        Flaw{"AnotherVersion", [](json* root) { (*root)["palpate_force_network"] = 2; },
             "palpate_force_network: expected 1"},
        Flaw{"AnotherArchitecture", [](json* root) { (*root)["architecture"] = "cnn"; },
             "architecture = cnn: expected rnn_21, rnn_19, dnn_21, dnn_19, tnn_21, tnn_19"},
        Flaw{"OtherInputs", [](json* root) { (*root)["architecture"] = "rnn_19"; },
             "inputs = 21: rnn_19 has 19"},
        Flaw{"RowMissing", [](json* root) { (*root)["lstm"][0]["kernel"].erase(0); },
             "lstm[0].kernel is 25 x 20, expected 26 x 20"},
        Flaw{"ShortRow", [](json* root) { (*root)["lstm"][1]["kernel"][2].erase(0); },
             "lstm[1].kernel[2] has 19 numbers, expected 20"},
        Flaw{"NoRows", [](json* root) { (*root)["lstm"][0]["kernel"] = json::array(); },
             "lstm[0].kernel: not a list of rows"},
        Flaw{"NoLayer", [](json* root) { (*root)["dense"] = json::array(); }, "no dense layer"},
        Flaw{"Null", [](json* root) { (*root)["lstm"][0]["kernel"][1][2] = nullptr; },
             "lstm[0].kernel[1][2]: not a number"},
        Flaw{"TooLarge", [](json* root) { (*root)["lstm"][0]["bias"][7] = 1e39; },
             "lstm[0].bias[7]: beyond single precision"},
        Flaw{"NoWindow", [](json* root) { (*root)["window"] = 0; }, "window = 0: expected 1 to"},
        Flaw{"TooFewOutputs", [](json* root) { (*root)["outputs"] = 2; },
             "outputs = 2: expected 3"},
        Flaw{"NoRate", [](json* root) { (*root)["rate"] = 0; }, "rate"},
        Flaw{"NoGain", [](json* root) { (*root)["gain"] = 0; }, "gain"},
        Flaw{"NegativeSigma",
             [](json* root) {
               (*root)["sigma"] = {1, -2, 3};
             },
             "sigma: expected three numbers >= 0"},
        Flaw{"NegativeError", [](json* root) { (*root)["relative_sigma"] = -1; },
             "relative_sigma: expected a number >= 0"},
        Flaw{"NoScale", [](json* root) { (*root)["input"]["scale"][20] = 0; },
             "input.scale contains a 0"},
        Flaw{"AnotherActivation", [](json* root) { (*root)["activation"] = "selu"; },
             "activation = selu: expected tanh, relu"}),
    [](const auto& flaw) { return std::string(flaw.param.name); });

// Values that only a network for a sensor without electrodes has.
TEST(NetworkFileTest, ChannelsWithoutWhatTheChecksCompareAreRefused) {
  json good = JsonOf(MakeRandomNetwork("dnn_19", 5, 0.3f, 1));
  good["unit"] = "kPa";
  good["noise"] = 0.05;
  good["sigma"] = {0.01, 0.01, 0.02};
  const std::vector<double> ones(19, 1.0);
  good["channels"] = {{"expectation", std::vector(19, std::vector<double>(19, 0.0))},
                      {"tolerance", ones},
                      {"relative_tolerance", ones},
                      {"below", ones},
                      {"above", ones},
                      {"second_difference", ones}};
  const Scratch scratch;
  const auto complaint = [&](const json& root) {
    scratch.Write("network.json", root.dump());
    return Thrown<std::runtime_error>([&] { LoadForceNetwork(scratch.path()); });
  };
  for (const char* key : {"sigma", "noise", "channels"}) {
    json root = good;
    root.erase(key);
    EXPECT_THAT(complaint(root), testing::HasSubstr(std::string(key) +
                                                    " is missing: a network with `unit` needs it; "
                                                    "train it again with"));
  }
  json unknown = good;
  unknown["sigma"] = {0, 0, 0};
  EXPECT_THAT(complaint(unknown), testing::HasSubstr("sigma: expected a number > 0"));
  json channels = good;
  channels["channels"]["expectation"] = {{0, 1}, {1, 0}};
  EXPECT_THAT(complaint(channels),
              testing::HasSubstr("channels.expectation is 2 x 2, expected 19 x 19"));
  scratch.Write("network.json", good.dump());
  EXPECT_EQ(LoadForceNetwork(scratch.path())->info().noise, 0.05);
}

TEST(NetworkFileTest, TextThatIsCutOffIsNoJson) {
  const std::string text = JsonOf(MakeRandomNetwork("rnn_21", 5, 0.3f, 1)).dump();
  const Scratch scratch;
  scratch.Write("network.json", text.substr(0, text.size() / 2));
  EXPECT_THAT(Thrown<std::runtime_error>([&] { LoadForceNetwork(scratch.path()); }),
              testing::HasSubstr("network.json: not JSON"));
}

}  // namespace
}  // namespace palpate
