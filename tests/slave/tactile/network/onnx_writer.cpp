#include "tests/slave/tactile/network/onnx_writer.h"

#include <cstdint>

namespace palpate {
namespace {

// The wire format of protocol buffers: a field is its number and type, then a varint or a length
// and so many bytes.
std::string Varint(std::uint64_t value) {
  std::string bytes;
  for (; value >= 0x80; value >>= 7) bytes += static_cast<char>(value | 0x80);
  return bytes + static_cast<char>(value);
}

std::string Number(int field, long value) {
  return Varint(static_cast<std::uint64_t>(field) << 3) + Varint(static_cast<std::uint64_t>(value));
}

std::string Bytes(int field, const std::string& content) {
  return Varint(static_cast<std::uint64_t>(field) << 3 | 2) + Varint(content.size()) + content;
}

std::string Float(int field, float value) {
  return Varint(static_cast<std::uint64_t>(field) << 3 | 5) +
         std::string(reinterpret_cast<const char*>(&value), sizeof value);
}

constexpr int kFloat = 1;                 // TensorProto.DataType
constexpr int kFactor = 1, kInteger = 2;  // AttributeProto.AttributeType

std::string Value(const std::string& name, const std::vector<long>& extents) {
  std::string shape;
  for (const long extent : extents) {
    shape += Bytes(1, extent > 0 ? Number(1, extent) : Bytes(2, "open"));
  }
  return Bytes(1, name) + Bytes(2, Bytes(1, Number(1, kFloat) + Bytes(2, shape)));
}

std::string WeightsOf(const OnnxWeights& weights) {
  std::string tensor;
  for (const long extent : weights.extents) tensor += Number(1, extent);
  const std::string raw(reinterpret_cast<const char*>(weights.data.data()),
                        weights.data.size() * sizeof(float));
  return tensor + Number(2, kFloat) + Bytes(8, weights.name) + Bytes(9, raw);
}

}  // namespace

std::string OnnxModel(const std::vector<long>& input, const std::vector<long>& output,
                      const std::vector<OnnxNode>& nodes, const std::vector<OnnxWeights>& weights) {
  std::string graph;
  for (const OnnxNode& node : nodes) {
    std::string fields;
    for (const std::string& name : node.inputs) fields += Bytes(1, name);
    fields += Bytes(2, node.output) + Bytes(3, "node " + node.output) + Bytes(4, node.op);
    for (const auto& [name, value] : node.attributes) {
      fields += Bytes(5, Bytes(1, name) + Number(3, value) + Number(20, kInteger));
    }
    for (const auto& [name, value] : node.factors) {
      fields += Bytes(5, Bytes(1, name) + Float(2, value) + Number(20, kFactor));
    }
    graph += Bytes(1, fields);
  }
  graph += Bytes(2, "network");
  for (const OnnxWeights& tensor : weights) graph += Bytes(5, WeightsOf(tensor));
  graph += Bytes(11, Value("x", input)) + Bytes(12, Value("y", output));
  const std::string opset = Bytes(1, "") + Number(2, 11);
  return Number(1, 6) + Bytes(2, "palpate's tests") + Bytes(7, graph) + Bytes(8, opset);
}

}  // namespace palpate
