#include "slave/tactile/network/onnx_graph.h"

#include <algorithm>
#include <cstdint>
#include <functional>
#include <limits>
#include <stdexcept>

#include <google/protobuf/unknown_field_set.h>

namespace palpate {
namespace {

using google::protobuf::UnknownField;
using google::protobuf::UnknownFieldSet;

// Numbers of the fields, as onnx.proto has them.
namespace field {
constexpr int kModelGraph = 7;
constexpr int kGraphNode = 1, kGraphWeights = 5, kGraphInput = 11, kGraphOutput = 12;
constexpr int kNodeOperator = 4;
constexpr int kTensorName = 8;
constexpr int kValueName = 1, kValueType = 2;
constexpr int kTypeTensor = 1, kTensorShape = 2, kShapeDimension = 1, kDimensionValue = 1;
}  // namespace field

// The fields of one message.
class Message {
 public:
  explicit Message(const std::string& bytes) {
    if (!fields_.ParseFromString(bytes)) throw std::runtime_error("not an ONNX model, or cut off");
  }
  // Calls with the bytes of every field of that number.
  void ForEach(int number, const std::function<void(const std::string&)>& call) const {
    for (int i = 0; i < fields_.field_count(); ++i) {
      const UnknownField& one = fields_.field(i);
      if (one.number() == number && one.type() == UnknownField::TYPE_LENGTH_DELIMITED) {
        call(one.length_delimited());
      }
    }
  }
  // The last one's bytes; empty: there is none.
  [[nodiscard]] std::string Text(int number) const {
    std::string text;
    ForEach(number, [&](const std::string& bytes) { text = bytes; });
    return text;
  }
  // 0: there is none.
  [[nodiscard]] long Number(int number) const {
    std::uint64_t value = 0;
    for (int i = 0; i < fields_.field_count(); ++i) {
      const UnknownField& one = fields_.field(i);
      if (one.number() == number && one.type() == UnknownField::TYPE_VARINT) value = one.varint();
    }
    const auto most = static_cast<std::uint64_t>(std::numeric_limits<int>::max());
    return static_cast<long>(std::min(value, most));
  }

 private:
  UnknownFieldSet fields_;
};

OnnxValue ReadValue(const std::string& bytes) {
  const Message value(bytes);
  OnnxValue read{value.Text(field::kValueName), {}};
  const Message type(value.Text(field::kValueType));
  const Message tensor(type.Text(field::kTypeTensor));
  const Message shape(tensor.Text(field::kTensorShape));
  shape.ForEach(field::kShapeDimension, [&](const std::string& dimension) {
    read.extents.push_back(Message(dimension).Number(field::kDimensionValue));
  });
  return read;
}

}  // namespace

OnnxGraph ReadOnnxGraph(std::string_view bytes) {
  const Message model{std::string(bytes)};
  const Message fields(model.Text(field::kModelGraph));
  OnnxGraph graph;
  std::vector<std::string> weights;
  fields.ForEach(field::kGraphWeights, [&](const std::string& tensor) {
    weights.push_back(Message(tensor).Text(field::kTensorName));
  });
  fields.ForEach(field::kGraphNode, [&](const std::string& node) {
    graph.operators.push_back(Message(node).Text(field::kNodeOperator));
  });
  fields.ForEach(field::kGraphInput, [&](const std::string& value) {
    OnnxValue input = ReadValue(value);
    const bool weight = std::find(weights.begin(), weights.end(), input.name) != weights.end();
    if (!weight) graph.inputs.push_back(std::move(input));
  });
  fields.ForEach(field::kGraphOutput,
                 [&](const std::string& value) { graph.outputs.push_back(ReadValue(value)); });
  if (graph.operators.empty()) throw std::runtime_error("not an ONNX model: it has no graph");
  return graph;
}

}  // namespace palpate
