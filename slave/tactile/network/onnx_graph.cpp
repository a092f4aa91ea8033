#include "slave/tactile/network/onnx_graph.h"

#include <algorithm>
#include <bit>
#include <cstdint>
#include <functional>
#include <iterator>
#include <limits>
#include <stdexcept>

#include <fmt/format.h>
#include <google/protobuf/io/coded_stream.h>
#include <google/protobuf/unknown_field_set.h>

namespace palpate {
namespace {

using google::protobuf::UnknownField;
using google::protobuf::UnknownFieldSet;

// Numbers of the fields, as onnx.proto has them.
namespace field {
constexpr int kModelGraph = 7;
constexpr int kGraphNode = 1, kGraphWeights = 5, kGraphInput = 11, kGraphOutput = 12;
constexpr int kNodeOperator = 4, kNodeAttribute = 5;
constexpr int kAttributeName = 1, kAttributeFloat = 2, kAttributeInteger = 3;
constexpr int kTensorExtents = 1, kTensorType = 2, kTensorName = 8, kTensorRaw = 9;
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
    ForFields(number, UnknownField::TYPE_LENGTH_DELIMITED,
              [&](const UnknownField& one) { call(one.length_delimited()); });
  }
  // The last one's bytes; empty: there is none.
  [[nodiscard]] std::string Text(int number) const {
    std::string text;
    ForEach(number, [&](const std::string& bytes) { text = bytes; });
    return text;
  }
  // All integers of that number, one by one or packed; beyond an int: the largest one.
  [[nodiscard]] std::vector<long> Numbers(int number) const {
    std::vector<long> numbers;
    const auto append = [&](std::uint64_t value) {
      const auto most = static_cast<std::uint64_t>(std::numeric_limits<int>::max());
      numbers.push_back(static_cast<long>(std::min(value, most)));
    };
    ForFields(number, UnknownField::TYPE_VARINT,
              [&](const UnknownField& one) { append(one.varint()); });
    ForEach(number, [&](const std::string& packed) {
      google::protobuf::io::CodedInputStream stream(
          reinterpret_cast<const std::uint8_t*>(packed.data()), static_cast<int>(packed.size()));
      std::uint64_t value = 0;
      while (stream.ReadVarint64(&value)) append(value);
    });
    return numbers;
  }
  // The last integer; 0: there is none.
  [[nodiscard]] long Number(int number) const {
    const std::vector<long> numbers = Numbers(number);
    return numbers.empty() ? 0 : numbers.back();
  }
  // The last single-precision number; 0: there is none.
  [[nodiscard]] float Float(int number) const {
    float value = 0;
    ForFields(number, UnknownField::TYPE_FIXED32,
              [&](const UnknownField& one) { value = std::bit_cast<float>(one.fixed32()); });
    return value;
  }
  // How many numbers of so many bytes there are of that number, one by one or packed.
  [[nodiscard]] std::size_t CountFixed(int number, std::size_t size) const {
    std::size_t count = 0;
    for (int i = 0; i < fields_.field_count(); ++i) {
      const UnknownField& one = fields_.field(i);
      if (one.number() != number) continue;
      const bool packed = one.type() == UnknownField::TYPE_LENGTH_DELIMITED;
      count += packed ? one.length_delimited().size() / size : 1;
    }
    return count;
  }

 private:
  template <typename Call>
  void ForFields(int number, UnknownField::Type type, const Call& call) const {
    for (int i = 0; i < fields_.field_count(); ++i) {
      const UnknownField& one = fields_.field(i);
      if (one.number() == number && one.type() == type) call(one);
    }
  }

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

// How the numbers of a type (TensorProto.DataType) are kept where they are not raw.
struct NumberType {
  long type;
  int field;
  std::size_t size;  // raw [bytes]
};
constexpr NumberType kFloat = {1, 4, 4}, kDouble = {11, 10, 8};
constexpr NumberType kNumberTypes[] = {kFloat,    kDouble,   {6, 5, 4}, {7, 7, 8},
                                       {2, 5, 1}, {3, 5, 1}, {9, 5, 1}, {10, 5, 2}};

// Name of a tensor of weights. Throws where its data do not fill its extents: the library that runs
// the model takes that for granted.
std::string CheckedWeights(const std::string& bytes) {
  const Message tensor(bytes);
  std::string name = tensor.Text(field::kTensorName);
  double count = 1;
  for (const long extent : tensor.Numbers(field::kTensorExtents)) {
    count *= static_cast<double>(extent);
  }
  const long type = tensor.Number(field::kTensorType);
  const auto* known = std::ranges::find(kNumberTypes, type, &NumberType::type);
  if (known == std::end(kNumberTypes)) {
    throw std::runtime_error("weights " + name + " are no numbers (type " + std::to_string(type) +
                             ")");
  }
  const bool fixed = type == kFloat.type || type == kDouble.type;
  std::size_t numbers = tensor.Text(field::kTensorRaw).size() / known->size;
  if (numbers == 0) {
    numbers =
        fixed ? tensor.CountFixed(known->field, known->size) : tensor.Numbers(known->field).size();
  }
  if (numbers == 0 || static_cast<double>(numbers) != count) {
    throw std::runtime_error("weights " + name + " do not fill their extents");
  }
  return name;
}

// y = alpha A B + beta C: of these factors and of a transposed A the library that runs the model
// takes no notice, and it wants B transposed. Throws naming what it would get wrong.
void RefuseOtherGemm(const Message& node) {
  float alpha = 1, beta = 1;
  long transA = 0, transB = 0;
  node.ForEach(field::kNodeAttribute, [&](const std::string& bytes) {
    const Message attribute(bytes);
    const std::string name = attribute.Text(field::kAttributeName);
    if (name == "alpha") alpha = attribute.Float(field::kAttributeFloat);
    if (name == "beta") beta = attribute.Float(field::kAttributeFloat);
    if (name == "transA") transA = attribute.Number(field::kAttributeInteger);
    if (name == "transB") transB = attribute.Number(field::kAttributeInteger);
  });
  const auto refuse = [](const std::string& what, const std::string& accepted) {
    throw std::runtime_error("operator Gemm: " + what + ": accepted is " + accepted);
  };
  if (alpha != 1) refuse(fmt::format("alpha = {:g}", alpha), "alpha = 1");
  if (beta != 1) refuse(fmt::format("beta = {:g}", beta), "beta = 1");
  if (transA != 0) refuse(fmt::format("transA = {}", transA), "transA = 0");
  if (transB != 1) refuse(fmt::format("transB = {}", transB), "transB = 1, or MatMul and Add");
}

}  // namespace

OnnxGraph ReadOnnxGraph(std::string_view bytes) {
  const Message model{std::string(bytes)};
  const Message fields(model.Text(field::kModelGraph));
  OnnxGraph graph;
  std::vector<std::string> weights;
  fields.ForEach(field::kGraphWeights,
                 [&](const std::string& tensor) { weights.push_back(CheckedWeights(tensor)); });
  fields.ForEach(field::kGraphNode, [&](const std::string& node) {
    const Message fields_of_node(node);
    graph.operators.push_back(fields_of_node.Text(field::kNodeOperator));
    if (graph.operators.back() == "Gemm") RefuseOtherGemm(fields_of_node);
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
