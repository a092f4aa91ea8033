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

std::string Text(const std::filesystem::path& file) {
  std::ifstream stream(file);
  return {std::istreambuf_iterator<char>(stream), {}};
}

// A sound network's file, changed.
class BrokenNetworkTest : public testing::Test {
 protected:
  BrokenNetworkTest() {
    const RandomNetwork sound = MakeRandomNetwork("rnn_21", 5, 0.3f, 1);
    WriteForceNetwork(scratch_.path(), sound.info, sound.weights);
    sound_ = Text(scratch_.path() / "network.json");
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
TEST(NetworkFileTest, WhatIsWrittenIsReadBackExactly) {
  for (const char* architecture : {"rnn_21", "rnn_19", "dnn_21", "dnn_19", "tnn_21", "tnn_19"}) {
    RandomNetwork network = MakeRandomNetwork(architecture, 20, 1, 2);
    network.info.gain = 1.0 / 3;
    network.info.sigma = {0.1, 0.02, 1e-7};
    network.info.learnt_force = 4.9;
    network.info.rest_sigma = 0.014;
    network.info.error = {0.002, 0.11};
    network.info.pattern.kinds = {
        {0.25, SignalPattern::Covariance::Identity() / 16, {0.001, 0.05}}};
    network.info.pattern.force.setConstant(0.125);
    network.info.origin = "a test's \"random\" numbers";
    network.weights.activation = HiddenActivation::kRelu;
    network.weights.dense[0].bias[0] = std::numeric_limits<float>::denorm_min();
    network.weights.dense[0].bias[1] = std::numeric_limits<float>::max();
    const Scratch scratch;
    const auto dir = scratch.path() / "made" / "here";
    WriteForceNetwork(dir, network.info, network.weights, R"({"epochs": 12})");
    const NetworkFile read = ReadForceNetwork(dir);
    EXPECT_EQ(read.info.architecture, architecture);
    EXPECT_EQ(read.info.inputs, network.info.inputs);
    EXPECT_EQ(read.info.window, network.info.window);
    EXPECT_EQ(read.info.outputs, network.info.outputs);
    EXPECT_EQ(read.info.rate, network.info.rate);
    EXPECT_EQ(read.info.gain, network.info.gain);
    EXPECT_EQ(read.info.sigma, network.info.sigma);
    EXPECT_EQ(read.info.learnt_force, network.info.learnt_force);
    EXPECT_EQ(read.info.rest_sigma, network.info.rest_sigma);
    EXPECT_EQ(read.info.error.growing, 0.002);
    EXPECT_EQ(read.info.error.relative, 0.11);
    ASSERT_EQ(read.info.pattern.kinds.size(), 1U);
    EXPECT_EQ(read.info.pattern.kinds[0].share, 0.25);
    EXPECT_EQ(read.info.pattern.kinds[0].error.growing, 0.001);
    EXPECT_EQ(read.info.pattern.kinds[0].error.relative, 0.05);
    EXPECT_EQ(read.info.pattern.kinds[0].shape, network.info.pattern.kinds[0].shape);
    EXPECT_EQ(read.info.pattern.force, network.info.pattern.force);
    EXPECT_EQ(read.info.origin, network.info.origin);
    EXPECT_EQ(json::parse(read.training)["epochs"], 12);
    EXPECT_EQ(read.weights.activation, HiddenActivation::kRelu);
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
    }
    EXPECT_EQ(LoadForceNetwork(dir)->info().gain, network.info.gain);
  }
}

TEST(NetworkFileTest, WhatMayBeLeftOutIsNeutral) {
  const RandomNetwork network = MakeRandomNetwork("dnn_19", 4, 0.3f, 3);
  const Scratch scratch;
  WriteForceNetwork(scratch.path(), network.info, network.weights);
  json root = json::parse(Text(scratch.path() / "network.json"));
  for (const char* key : {"gain", "sigma", "learnt_force", "origin", "training", "input", "lstm",
                          "activation", "output"}) {
    root.erase(key);
  }
  scratch.Write("network.json", root.dump());
  const NetworkFile read = ReadForceNetwork(scratch.path());
  EXPECT_EQ(read.info.gain, 1);
  EXPECT_EQ(read.info.sigma, Eigen::Vector3d(0, 0, 0));
  EXPECT_EQ(read.training, "{}");
  EXPECT_EQ(read.weights.input_scale, Eigen::VectorXf::Ones(19));
  EXPECT_EQ(read.weights.output_mean, Eigen::VectorXf::Zero(4));
}

TEST(NetworkFileTest, WhatDoesNotFitIsNotWritten) {
  RandomNetwork network = MakeRandomNetwork("rnn_21", 5, 0.3f, 4);
  const Scratch scratch;
  EXPECT_THROW(WriteForceNetwork(scratch.path(), network.info, network.weights, "[1"),
               std::invalid_argument);
  EXPECT_THROW(WriteForceNetwork("/dev/null/here", network.info, network.weights),
               std::runtime_error);
  network.weights.lstm[1].bias[3] = std::numeric_limits<float>::quiet_NaN();
  EXPECT_THROW(WriteForceNetwork(scratch.path(), network.info, network.weights),
               std::invalid_argument);
  EXPECT_THROW(MakeForceNetwork(network.info, network.weights), std::invalid_argument);
  EXPECT_FALSE(std::filesystem::exists(scratch.path() / "network.json"));
}

TEST_F(BrokenNetworkTest, WhatIsNotThereIsNamed) {
  EXPECT_SAYS(ErrorOf(scratch_.path() / "elsewhere"), "elsewhere: there is no such file or folder");
  std::filesystem::remove(scratch_.path() / "network.json");
  EXPECT_SAYS(ErrorOf(scratch_.path()), "contains neither network.json nor tensors.json");
  for (const char* key :
       {"architecture", "inputs", "window", "outputs", "rate", "palpate_force_network"}) {
    EXPECT_SAYS(ErrorAfter([&](json* root) { root->erase(key); }),
                key + std::string(" is missing"));
  }
  EXPECT_SAYS(ErrorAfter([](json* root) { (*root)["lstm"][1].erase("bias"); }),
              "network.json: lstm[1].bias is missing");
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
              "architecture = cnn: accepted is rnn_21, rnn_19, dnn_21, dnn_19, tnn_21, tnn_19");
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
  EXPECT_SAYS(ErrorAfter([](json* root) { (*root)["window"] = 0; }),
              "window = 0: accepted is 1 to");
  EXPECT_SAYS(ErrorAfter([](json* root) { (*root)["inputs"] = -1; }), "inputs");
  EXPECT_SAYS(ErrorAfter([](json* root) { (*root)["outputs"] = 2; }), "outputs = 2: accepted is 3");
  EXPECT_SAYS(ErrorAfter([](json* root) { (*root)["rate"] = 0; }), "rate");
  EXPECT_SAYS(ErrorAfter([](json* root) { (*root)["gain"] = 0; }), "gain");
  EXPECT_SAYS(ErrorAfter([](json* root) { (*root)["sigma"] = {1, 2}; }), "sigma");
  EXPECT_SAYS(ErrorAfter([](json* root) {
                (*root)["sigma"] = {1, -2, 3};
              }),
              "sigma: accepted are three numbers >= 0");
  for (const char* key : {"rest_sigma", "learnt_force", "growing_variance", "relative_sigma"}) {
    EXPECT_SAYS(ErrorAfter([&](json* root) { (*root)[key] = -1; }),
                std::string(key) + ": accepted is a number >= 0");
  }
  EXPECT_SAYS(ErrorAfter([](json* root) { (*root)["input"]["scale"][20] = 0; }),
              "input.scale contains a 0");
  EXPECT_SAYS(ErrorAfter([](json* root) { (*root)["palpate_force_network"] = 2; }),
              "palpate_force_network: accepted is 1");
  EXPECT_SAYS(ErrorAfter([](json* root) { (*root)["activation"] = "selu"; }),
              "activation = selu: accepted is tanh or relu");
}

// The layout of the authors' weights, made of a random network.
json TensorsOf(const RandomNetwork& network) {
  json root;
  const auto put = [&](const std::string& name, const auto& matrix, std::vector<int> shape) {
    json data = json::array();
    for (Eigen::Index k = 0; k < matrix.size(); ++k) data.push_back(matrix.data()[k]);
    root[name] = {{"shape", shape}, {"dtype", "float32"}, {"data", data}};
  };
  const auto extent = [](Eigen::Index n) { return static_cast<int>(n); };
  for (std::size_t k = 0; k < 2; ++k) {
    const LstmLayer& layer = network.weights.lstm[k];
    const std::string name = "layer" + std::to_string(k + 1);
    put(name + "/cell/Matrix", layer.kernel,
        {extent(layer.kernel.rows()), extent(layer.kernel.cols())});
    put(name + "/cell/Bias", layer.bias, {extent(layer.bias.size())});
  }
  const DenseLayer& last = network.weights.dense.back();
  put("output_layer/W", last.kernel, {extent(last.kernel.rows()), extent(last.kernel.cols())});
  put("output_layer/b", last.bias, {extent(last.bias.size())});
  root["Global_Step"] = {{"shape", json::array()}, {"data", {12}}};
  return root;
}

class TensorsFileTest : public testing::Test {
 protected:
  TensorsFileTest() : network_(MakeRandomNetwork("rnn_21", 6, 0.3f, 5)) {
    network_.weights.LeaveUnscaled(21, 4);
    network_.info.gain = 1;
  }
  std::string ErrorAfter(const std::function<void(json*)>& change) {
    json root = TensorsOf(network_);
    change(&root);
    scratch_.Write("tensors.json", root.dump());
    return ErrorOf(scratch_.path());
  }
  Scratch scratch_;
  RandomNetwork network_;
};

TEST_F(TensorsFileTest, TensorsAreTheNetworkThatTheyAreMadeOf) {
  ASSERT_EQ(ErrorAfter([](json*) {}), "");
  const auto read = LoadForceNetwork(scratch_.path());
  const auto one = read->Windowed();
  const auto other = MakeForceNetwork(network_.info, network_.weights)->Windowed();
  std::array<double, 4> y{}, expected{};
  for (const auto& sample : RandomSignals(60, 2, 6)) {
    EXPECT_EQ(one->Push(sample, y), other->Push(sample, expected));
  }
  EXPECT_EQ(y, expected);
  EXPECT_NE(y, (std::array<double, 4>{}));
}

TEST_F(TensorsFileTest, WhatIsWrongIsNamed) {
  EXPECT_SAYS(ErrorAfter([](json* root) { root->erase("layer1/cell/Matrix"); }),
              "tensors.json: tensor layer1/.../Matrix is missing");
  EXPECT_SAYS(ErrorAfter([](json* root) { root->erase("layer2/cell/Bias"); }),
              "tensor layer2/.../Bias is missing");
  EXPECT_SAYS(ErrorAfter([](json* root) { root->erase("output_layer/b"); }),
              "tensor output_layer/.../b is missing");
  EXPECT_SAYS(ErrorAfter([](json* root) {
                (*root)["layer1/cell/Matrix"]["shape"] = {27, 25};
              }),
              "tensor layer1/cell/Matrix.data has 648 numbers, its shape is 27 x 25");
  EXPECT_SAYS(ErrorAfter([](json* root) { (*root)["layer1/cell/Matrix"]["shape"] = {648}; }),
              "is 648, expected rows x columns");
  EXPECT_SAYS(ErrorAfter([](json* root) {
                (*root)["layer1/cell/Matrix"]["shape"] = {24, 27};
              }),
              "inputs");
  EXPECT_SAYS(ErrorAfter([](json* root) {
                (*root)["layer2/cell/Matrix"]["shape"] = {24, 12};
              }),
              "lstm[1].kernel");
  EXPECT_SAYS(ErrorAfter([](json* root) { (*root)["output_layer/W"]["data"][3] = nullptr; }),
              "tensor output_layer/W.data[3]: not a number");
  EXPECT_SAYS(ErrorAfter([](json* root) {
                (*root)["output_layer/W"]["shape"] = {-1, 2};
              }),
              "tensor output_layer/W.shape: accepted are extents");
}

}  // namespace
}  // namespace palpate
