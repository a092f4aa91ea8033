// What an ONNX file says of its graph, as far as one must know before a library runs it.
#pragma once

#include <string>
#include <string_view>
#include <vector>

namespace palpate {

struct OnnxValue {
  std::string name;
  std::vector<long> extents;  // 0: not fixed
};

struct OnnxGraph {
  std::vector<OnnxValue> inputs;  // those that are not weights
  std::vector<OnnxValue> outputs;
  std::vector<std::string> operators;  // of the nodes, in their order
};

// Throws std::runtime_error: the bytes are no ONNX model; a Gemm with attributes of which OpenCV
// takes no notice (alpha, beta, transA) or that it does not run (transB = 0).
OnnxGraph ReadOnnxGraph(std::string_view bytes);

}  // namespace palpate
