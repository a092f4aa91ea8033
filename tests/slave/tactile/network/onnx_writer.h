// Small ONNX models, byte by byte.
#pragma once

#include <map>
#include <string>
#include <vector>

namespace palpate {

struct OnnxWeights {
  std::string name;
  std::vector<long> extents;
  std::vector<float> data;
};

struct OnnxNode {
  std::string op;
  std::vector<std::string> inputs;
  std::string output;
  std::map<std::string, long> attributes = {};
  std::map<std::string, float> factors = {};  // attributes that are not whole
};

// One input `x` and one output `y` of these extents; 0: left open.
std::string OnnxModel(const std::vector<long>& input, const std::vector<long>& output,
                      const std::vector<OnnxNode>& nodes, const std::vector<OnnxWeights>& weights);

}  // namespace palpate
