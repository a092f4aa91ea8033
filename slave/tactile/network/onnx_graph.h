// The graph of an ONNX file, as far as it must be known before a library runs it.
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

// Throws std::runtime_error: the bytes are not an ONNX model; a Gemm with attributes that OpenCV
// ignores (alpha, beta, transA) or does not support (transB = 0).
OnnxGraph ReadOnnxGraph(std::string_view bytes);

}  // namespace palpate
