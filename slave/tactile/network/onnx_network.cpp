#include <algorithm>
#include <bit>
#include <cmath>
#include <cstdint>
#include <fstream>
#include <functional>
#include <iterator>
#include <limits>
#include <map>
#include <numeric>
#include <optional>
#include <stdexcept>
#include <string>
#include <string_view>
#include <utility>
#include <vector>

#include <fmt/format.h>
#include <google/protobuf/io/coded_stream.h>
#include <google/protobuf/unknown_field_set.h>
#include <opencv2/core/utils/logger.hpp>
#include <opencv2/dnn.hpp>

#include "shared/text/text.h"
#include "slave/tactile/network/network_file.h"

namespace palpate {
namespace {

using google::protobuf::UnknownField;
using google::protobuf::UnknownFieldSet;

// Numbers of the fields, as onnx.proto has them.
namespace field {
constexpr int kModelGraph = 7;
constexpr int kGraphNode = 1, kGraphWeights = 5, kGraphInput = 11, kGraphOutput = 12;
constexpr int kNodeInput = 1, kNodeOutput = 2, kNodeOperator = 4, kNodeAttribute = 5;
constexpr int kAttributeName = 1, kAttributeFloat = 2, kAttributeInteger = 3, kAttributeText = 4,
              kAttributeTensor = 5;
constexpr int kTensorExtents = 1, kTensorType = 2, kTensorName = 8, kTensorRaw = 9,
              kTensorLocation = 14;
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

// The graph of an ONNX file, as far as it must be known before a library runs it.
struct OnnxValue {
  std::string name;
  std::vector<long> extents;  // 0: not fixed
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
  if (tensor.Number(field::kTensorLocation) != 0) {
    throw std::runtime_error("weights " + name +
                             " are external data (in another file): accepted are weights in the "
                             "file itself (torch.onnx.export: external_data=False)");
  }
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

[[noreturn]] void RefuseOperator(const std::string& name, const std::string& what,
                                 const std::string& accepted) {
  throw std::runtime_error("operator " + name + ": " + what + ": accepted is " + accepted);
}

// Operators that OpenCV computes as ONNX defines them, with their attributes. Of most others, and
// of other values of these attributes, it takes no notice or gives another result.
struct KnownAttribute {
  std::string_view name;
  std::optional<std::string_view> only;  // the value that is computed right; nullopt: any
  std::string_view absent;               // its value where it is absent
};
struct KnownOperator {
  std::string_view name;
  std::vector<KnownAttribute> attributes;
  bool is_same_shape = false;  // one input and output of the same extents
};
const std::vector<KnownOperator>& KnownOperators() {
  static const std::vector<KnownOperator> known{
      {"Gemm",
       {{"alpha", "1", "1"}, {"beta", "1", "1"}, {"transA", "0", "0"}, {"transB", "1", "0"}}},
      {"MatMul", {}},
      {"Add", {}},
      {"Sub", {}},
      {"Mul", {}},
      {"Div", {}},
      {"Tanh", {}, true},
      {"Relu", {}, true},
      {"Sigmoid", {}, true},
      {"LeakyRelu", {{"alpha", {}, {}}}, true},
      {"Elu", {{"alpha", {}, {}}}, true},
      {"Identity", {}, true},
      {"Flatten", {{"axis", "1", "1"}}},
      {"Reshape", {{"allowzero", "0", "0"}}},
      {"Transpose", {{"perm", {}, {}}}},
      {"Squeeze", {{"axes", {}, {}}}},
      {"Unsqueeze", {{"axes", {}, {}}}},
      {"Slice", {{"axes", {}, {}}, {"starts", {}, {}}, {"ends", {}, {}}}},
      {"Gather", {{"axis", {}, {}}}},
      {"Concat", {{"axis", {}, {}}}},
      {"Constant", {{"value", {}, {}}}},
      {"LSTM",
       {{"hidden_size", {}, {}},
        {"direction", "forward", "forward"},
        {"layout", "0", "0"},
        {"input_forget", "0", "0"}}},
      {"GRU",
       {{"hidden_size", {}, {}},
        {"direction", "forward", "forward"},
        {"layout", "0", "0"},
        {"linear_before_reset", "1", "0"}}}};
  return known;
}

// The value of an attribute in words, for messages and comparisons.
std::string ValueOf(const Message& attribute) {
  const std::string text = attribute.Text(field::kAttributeText);
  if (!text.empty()) return text;
  const float number = attribute.Float(field::kAttributeFloat);
  return number != 0 ? fmt::format("{:g}", number)
                     : std::to_string(attribute.Number(field::kAttributeInteger));
}

const KnownOperator& RequireKnown(const Message& node) {
  const std::string name = node.Text(field::kNodeOperator);
  const auto known = std::ranges::find(KnownOperators(), name, &KnownOperator::name);
  if (known == KnownOperators().end()) {
    std::string all;
    for (const KnownOperator& one : KnownOperators()) {
      all.append(all.empty() ? "" : " ").append(one.name);
    }
    RefuseOperator(name, "is not supported", "one of " + all);
  }
  std::map<std::string, std::string> values;
  node.ForEach(field::kNodeAttribute, [&](const std::string& bytes) {
    const Message attribute(bytes);
    values[attribute.Text(field::kAttributeName)] = ValueOf(attribute);
  });
  for (const KnownAttribute& attribute : known->attributes) {
    const std::string key(attribute.name);
    const std::string value = values.contains(key) ? values[key] : std::string(attribute.absent);
    values.erase(key);
    if (!attribute.only || value == *attribute.only) continue;
    RefuseOperator(name, key + " = " + value,
                   key + " = " + std::string(*attribute.only) +
                       (name == "Gemm" && key == "transB" ? ", or MatMul and Add" : ""));
  }
  if (!values.empty()) {
    RefuseOperator(name, "attribute " + values.begin()->first + " = " + values.begin()->second,
                   "none of that name");
  }
  return *known;
}

// Follows the extents of the values from node to node, as far as they are needed: OpenCV repeats a
// constant along another axis than ONNX where a value has more than two.
class OperatorCheck {
 public:
  explicit OperatorCheck(std::map<std::string, std::vector<long>> constants)
      : constants_(std::move(constants)) {}
  void AddInput(const std::string& name, const std::vector<long>& extents) {
    extents_[name] = extents;
    if (!extents.empty()) extents_[name].front() = 1;  // the batch
  }

  void Check(const Message& node) {
    const KnownOperator& known = RequireKnown(node);
    name_ = known.name;
    inputs_.clear();
    node.ForEach(field::kNodeInput, [&](const std::string& input) { inputs_.push_back(input); });
    const std::string output = node.Text(field::kNodeOutput);
    if (name_ == "Constant") {
      node.ForEach(field::kNodeAttribute, [&](const std::string& bytes) {
        const Message tensor(Message(bytes).Text(field::kAttributeTensor));
        constants_[output] = tensor.Numbers(field::kTensorExtents);
      });
    } else if (known.is_same_shape) {
      if (const auto found = extents_.find(Input(0)); found != extents_.end()) {
        extents_[output] = found->second;
      }
    } else if (name_ == "Flatten") {
      const auto value = extents_.find(Input(0));
      const bool is_known = value != extents_.end();
      extents_[output] = {1, is_known ? std::accumulate(value->second.begin(), value->second.end(),
                                                        1L, std::multiplies<>())
                                      : 0};
    } else if (name_ == "Gemm") {
      const auto factor = constants_.find(Input(1));
      const bool is_known = factor != constants_.end() && !factor->second.empty();
      extents_[output] = {1, is_known ? factor->second.front() : 0};
    } else if (name_ == "MatMul") {
      CheckMatMul(output);
    } else if (name_ == "Add" || name_ == "Sub" || name_ == "Mul" || name_ == "Div") {
      CheckArithmetic(output);
    } else if (name_ == "LSTM" || name_ == "GRU") {
      CheckRecurrent();
    } else if (name_ == "Slice" && !Input(4).empty()) {
      Refuse("has an input `steps`", "none");
    }
  }

 private:
  [[noreturn]] void Refuse(const std::string& what, const std::string& accepted) const {
    RefuseOperator(name_, what, accepted);
  }
  [[nodiscard]] std::string Input(std::size_t i) const {
    return i < inputs_.size() ? inputs_[i] : std::string();
  }

  void CheckMatMul(const std::string& output) {
    if (constants_.contains(Input(0))) Refuse("a constant before the value", "it behind the value");
    if (const auto found = extents_.find(Input(0)); found != extents_.end()) {
      const auto factor = constants_.find(Input(1));
      const bool is_known = factor != constants_.end() && !factor->second.empty();
      extents_[output] = found->second;
      extents_[output].back() = is_known ? factor->second.back() : 0;
    }
  }

  void CheckArithmetic(const std::string& output) {
    const bool is_swapped = constants_.contains(Input(0));
    if (is_swapped && (name_ == "Sub" || name_ == "Div")) {
      Refuse("a constant before the value", "it behind the value");
    }
    const auto value = extents_.find(Input(is_swapped ? 1 : 0));
    const bool is_known = value != extents_.end();
    const auto constant = constants_.find(Input(is_swapped ? 0 : 1));
    if (constant == constants_.end()) {
      const auto other = extents_.find(Input(1));
      const bool is_same = is_known && other != extents_.end() && other->second == value->second &&
                           std::ranges::find(value->second, 0) == value->second.end();
      if (!is_same) Refuse("two values of extents that differ or are not known", "equal ones");
    } else {
      const std::vector<long>& extents = constant->second;
      const auto is_one = [](long extent) { return extent == 1; };
      const bool is_number = std::ranges::all_of(extents, is_one);
      const bool is_row = is_known && value->second.size() == 2 && !extents.empty() &&
                          extents.size() <= 2 && extents.back() == value->second.back() &&
                          std::all_of(extents.begin(), extents.end() - 1, is_one);
      if (!is_number && !is_row) {
        Refuse("constant " + constant->first + " on a window or a value of unknown extents",
               "a single number, or a row [n] on a value [1, n] (Flatten before it)");
      }
    }
    if (is_known) extents_[output] = value->second;
  }

  void CheckRecurrent() const {
    if (!Input(4).empty()) Refuse("has an input sequence_lens", "none");
    if (name_ == "LSTM" && !Input(7).empty()) Refuse("has an input P (peephole weights)", "none");
    if (name_ == "GRU" && Input(5).empty()) Refuse("has no input initial_h", "one of zeros");
    if (Input(3).empty()) Refuse("has no input B", "one of zeros");
  }

  std::map<std::string, std::vector<long>> constants_, extents_;  // 0: not known
  std::string name_;
  std::vector<std::string> inputs_;  // of the node
};

struct OnnxGraph {
  std::vector<OnnxValue> inputs;  // those that are not weights
  std::vector<OnnxValue> outputs;
  std::vector<std::string> operators;  // of the nodes, in their order
};

// Throws std::runtime_error: the bytes are not an ONNX model; an operator or attribute that OpenCV
// does not compute as ONNX defines it, by name.
OnnxGraph ReadOnnxGraph(std::string_view bytes) {
  const Message model{std::string(bytes)};
  const Message fields(model.Text(field::kModelGraph));
  OnnxGraph graph;
  std::map<std::string, std::vector<long>> weights;
  fields.ForEach(field::kGraphWeights, [&](const std::string& tensor) {
    weights[CheckedWeights(tensor)] = Message(tensor).Numbers(field::kTensorExtents);
  });
  fields.ForEach(field::kGraphInput, [&](const std::string& value) {
    OnnxValue input = ReadValue(value);
    if (!weights.contains(input.name)) graph.inputs.push_back(std::move(input));
  });
  fields.ForEach(field::kGraphOutput,
                 [&](const std::string& value) { graph.outputs.push_back(ReadValue(value)); });
  OperatorCheck check(std::move(weights));
  for (const OnnxValue& input : graph.inputs) check.AddInput(input.name, input.extents);
  fields.ForEach(field::kGraphNode, [&](const std::string& node) {
    const Message fields_of_node(node);
    graph.operators.push_back(fields_of_node.Text(field::kNodeOperator));
    check.Check(fields_of_node);
  });
  if (graph.operators.empty()) throw std::runtime_error("not an ONNX model: it has no graph");
  return graph;
}

namespace fs = std::filesystem;

constexpr int kOpenWindow = 50;
constexpr int kLargestWindow = 1000;
constexpr std::uintmax_t kLargestFile = 256u << 20;  // [bytes]

// OpenCV tells its troubles to stderr as well; what is thrown says them.
class Silence {
 public:
  Silence() : before_(cv::utils::logging::setLogLevel(cv::utils::logging::LOG_LEVEL_SILENT)) {}
  ~Silence() { cv::utils::logging::setLogLevel(before_); }
  Silence(const Silence&) = delete;
  Silence& operator=(const Silence&) = delete;

 private:
  cv::utils::logging::LogLevel before_;
};

struct Model {
  std::vector<char> bytes;
  std::vector<int> shape;  // of the input, batch 1
  std::string output;
  int inputs = 0;
  int window = 1;
  int outputs = 0;
};

std::string InWords(const std::vector<long>& extents) {
  std::string words = "[";
  for (const long extent : extents) {
    if (words.size() > 1) words += ", ";
    words += extent > 0 ? std::to_string(extent) : "?";
  }
  return words + "]";
}

std::vector<char> ReadBytes(const fs::path& file) {
  std::error_code error;
  const auto size = fs::file_size(file, error);
  std::ifstream stream(file, std::ios::binary);
  if (error || !stream) throw std::runtime_error("cannot be read");
  if (size > kLargestFile) throw std::runtime_error("larger than 256 MB");
  return {std::istreambuf_iterator<char>(stream), {}};
}

void ReadShapes(const OnnxGraph& graph, Model* model) {
  if (graph.inputs.size() != 1) {
    throw std::runtime_error("it has " + std::to_string(graph.inputs.size()) +
                             " inputs, expected one");
  }
  const std::vector<long>& extents = graph.inputs[0].extents;
  const bool sequence = extents.size() == 3;
  const long window = !sequence ? 1 : extents[1] == 0 ? kOpenWindow : extents[1];
  const bool fits = (sequence || extents.size() == 2) && extents[0] <= 1 &&
                    (extents.back() == 19 || extents.back() == 21) && window <= kLargestWindow;
  if (!fits) {
    throw std::runtime_error("input " + graph.inputs[0].name + " is " + InWords(extents) +
                             ", expected [1, n] or [1, window, n] with n = 19 or 21 and a window " +
                             "of at most " + std::to_string(kLargestWindow));
  }
  if (graph.outputs.empty()) throw std::runtime_error("it has no output");
  model->output = graph.outputs[0].name;
  model->inputs = static_cast<int>(extents.back());
  model->window = static_cast<int>(window);
  model->shape = {1, model->inputs};
  if (sequence) model->shape = {1, model->window, model->inputs};
}

// The operator that OpenCV complains of, where it names one, and its reason: the innermost of
// `... error: REASON in function ...`.
std::string Complaint(const std::string& what, const OnnxGraph& graph) {
  std::string subject = "OpenCV cannot run it: ";
  for (const std::string& name : graph.operators) {
    const bool meant = what.find("[" + name + "@") != std::string::npos ||
                       what.find("of type \"" + name + "\"") != std::string::npos;
    if (meant) subject = "operator " + name + " is not supported by this OpenCV: ";
  }
  const std::size_t begin = what.rfind("error: ");
  if (begin == std::string::npos) return subject + what;
  const std::size_t end = what.find(" in function", begin);
  return subject + what.substr(begin + 7, end == std::string::npos ? end : end - begin - 7);
}

class OnnxEstimate final : public ForceEstimate {
 public:
  explicit OnnxEstimate(std::shared_ptr<const Model> model)
      : model_(std::move(model)),
        net_(cv::dnn::readNetFromONNX(model_->bytes.data(), model_->bytes.size())),
        input_(model_->shape, CV_32F, cv::Scalar(0)) {
    net_.setPreferableBackend(cv::dnn::DNN_BACKEND_OPENCV);
    net_.setPreferableTarget(cv::dnn::DNN_TARGET_CPU);
  }

  // The outputs for what the input holds, one row. Throws cv::Exception.
  cv::Mat Forward() {
    net_.setInput(input_);
    return net_.forward(model_->output);
  }

  void Reset() noexcept override { seen_ = 0; }
  bool Push(const TactileSignals& change, std::span<double> outputs) noexcept override {
    const auto end = change.begin() + model_->inputs;
    if (!std::all_of(change.begin(), end, [](auto x) { return std::isfinite(x); })) {
      Reset();
      return false;
    }
    // The oldest sample comes first.
    const std::span<float> samples(input_.ptr<float>(), input_.total());
    const auto newest =
        std::rotate(samples.begin(), samples.begin() + model_->inputs, samples.end());
    std::copy(change.begin(), end, newest);
    seen_ = std::min(seen_ + 1, model_->window);
    return seen_ == model_->window && Evaluate(outputs);
  }

 private:
  bool Evaluate(std::span<double> outputs) noexcept {
    try {
      const cv::Mat row = Forward();
      if (row.total() != outputs.size() || row.type() != CV_32F) return false;
      const auto* numbers = row.ptr<float>();
      std::copy(numbers, numbers + outputs.size(), outputs.begin());
      return std::all_of(outputs.begin(), outputs.end(), [](double y) { return std::isfinite(y); });
    } catch (...) {
      return false;
    }
  }

  std::shared_ptr<const Model> model_;
  cv::dnn::Net net_;
  cv::Mat input_;
  int seen_ = 0;
};

// Runs the model once on an untouched fingertip.
int CountOutputs(const std::shared_ptr<const Model>& model) {
  const cv::Mat row = OnnxEstimate(model).Forward();
  std::vector<long> extents(row.size.p, row.size.p + row.dims);
  const auto total = static_cast<long>(row.total());
  if (row.type() != CV_32F || extents.empty() || extents.back() != total || total < 3) {
    throw std::runtime_error("output " + model->output + " is " + InWords(extents) +
                             ", expected one row of 3 or more (fx, fy, fz first)");
  }
  if (!cv::checkRange(row)) throw std::runtime_error("its outputs at rest are not finite");
  return static_cast<int>(total);
}

class OnnxNetwork final : public ForceNetwork {
 public:
  OnnxNetwork(std::shared_ptr<const Model> model, std::string origin) : model_(std::move(model)) {
    info_.architecture = "onnx";
    info_.inputs = model_->inputs;
    info_.window = model_->window;
    info_.outputs = model_->outputs;
    info_.origin = std::move(origin);
  }

  [[nodiscard]] const NetworkInfo& info() const override { return info_; }
  [[nodiscard]] std::unique_ptr<ForceEstimate> Windowed() const override {
    const Silence silence;
    return std::make_unique<OnnxEstimate>(model_);
  }

 private:
  NetworkInfo info_;
  std::shared_ptr<const Model> model_;
};

std::shared_ptr<const Model> ReadModel(const fs::path& file) {
  Model model;
  model.bytes = ReadBytes(file);
  const OnnxGraph graph = ReadOnnxGraph({model.bytes.data(), model.bytes.size()});
  ReadShapes(graph, &model);
  try {
    const Silence silence;
    model.outputs = CountOutputs(std::make_shared<Model>(model));
  } catch (const cv::Exception& error) {
    throw std::runtime_error(Complaint(error.what(), graph));
  }
  return std::make_shared<Model>(std::move(model));
}

}  // namespace

std::unique_ptr<ForceNetwork> LoadOnnxNetwork(const fs::path& file) {
  return NamingFile(file, [&]() -> std::unique_ptr<ForceNetwork> {
    return std::make_unique<OnnxNetwork>(ReadModel(file), "ONNX model " + file.filename().string());
  });
}

}  // namespace palpate
